"""Results are kept as they come; what ends it tells how to go on, and loses nothing."""

import signal

import pytest
from quick_jobs import Square

from bdt_msgs_py.command_errors import LoopError
from bdt_study.engine.in_this_process import InThisProcess
from bdt_study.engine.job_progress import JobProgress
from bdt_study.engine.kept_results import keep_results


@pytest.fixture
def kept(tmp_path):
    """Return a function that keeps squares below 25, with something done after each."""

    def keeping(after=lambda _: None, engine=None):
        there = {}

        def keep(number, result):
            there[number] = result
            after(number)

        progress = JobProgress("squares", 5)
        engine = engine or InThisProcess()
        try:
            keep_results(engine, map(Square, range(5)), keep, progress, tmp_path)
        finally:
            keeping.there = there

    return keeping


def press_ctrl_c(_number):
    signal.raise_signal(signal.SIGINT)


def test_all_are_kept(kept):
    kept()
    assert kept.there == {0: 0, 1: 1, 2: 4, 3: 9, 4: 16}


class TwoAhead(InThisProcess):
    """An engine that asks for two jobs before it does them."""

    def results(self, jobs):
        for job in jobs:
            yield from super().results(iter([job, *([next(jobs)] if job.number < 4 else [])]))


def test_ctrl_c_lets_what_is_in_work_be_finished(kept):
    kept(lambda number: press_ctrl_c(number) if number == 0 else None, TwoAhead())
    assert kept.there == {0: 0, 1: 1}


def test_another_ctrl_c_does_not_wait(kept):
    with pytest.raises(KeyboardInterrupt):
        kept(press_ctrl_c, TwoAhead())
    assert kept.there == {0: 0, 1: 1}


def test_a_full_disk_ends_it_with_what_there_is(kept, tmp_path):
    def fill(number):
        if number == 2:
            raise OSError(28, "No space left on device")

    with pytest.raises(LoopError) as ended:
        kept(fill)
    assert str(ended.value) == (
        f"{tmp_path}: cannot be written: No space left on device; what is there is whole: go on "
        "with --resume"
    )


def test_workers_that_are_lost_end_it_with_what_there_is(kept):
    class Lost(InThisProcess):
        def results(self, jobs):
            yield next(super().results(jobs))
            raise LoopError("the workers are gone")

    with pytest.raises(LoopError, match=r"^the workers are gone; what is there is whole: go on"):
        kept(engine=Lost())
    assert kept.there == {0: 0}
