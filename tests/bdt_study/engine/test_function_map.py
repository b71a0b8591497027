"""A function on an engine gives what `map` gives, whatever comes first."""

from functools import partial

from quick_jobs import slept

from bdt_study.engine.function_map import mapped
from bdt_study.engine.in_this_process import InThisProcess
from bdt_study.engine.local_workers import LocalWorkers


class LastFirst(InThisProcess):
    """An engine that has finished the last job first."""

    def results(self, jobs):
        yield from reversed(list(super().results(jobs)))


def test_results_come_in_the_order_of_the_arguments():
    assert list(mapped(LastFirst(), abs, range(-9, 0))) == list(range(9, 0, -1))


def test_each_result_comes_as_soon_as_those_before_it_are_there():
    asked = []
    results = mapped(InThisProcess(), asked.append, iter(range(5)))
    next(results)
    assert asked == [0]


def test_processes_do_it_as_well():
    durations = [0.3, 0.0, 0.1, 0.0]
    with LocalWorkers(2) as engine:
        assert list(mapped(engine, partial(slept), durations)) == durations
