"""Workers: every job is done once, whoever is killed; nobody outlives whoever gave the work."""

import os
import signal
import time
from multiprocessing import active_children
from pathlib import Path

import pytest
from quick_jobs import End, Refuse, Sleep, Square

from bdt_msgs_py.command_errors import BadInputError, LoopError
from bdt_study.engine import local_workers
from bdt_study.engine.local_workers import LocalWorkers

DEADLINE = 60.0


def wait_for(condition):
    end = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def exist(processes):
    return any(Path(f"/proc/{process}").exists() for process in processes)


def test_every_job_is_done_once_though_workers_are_killed():
    done = []
    with LocalWorkers(2) as engine:
        for number, result in engine.results(map(Square, range(200))):
            assert result == number**2
            done.append(number)
            if len(done) in (1, 100):
                os.kill(active_children()[0].pid, signal.SIGKILL)
    assert sorted(done) == list(range(200))


def test_workers_stay_from_one_work_to_the_next_and_end_with_the_engine():
    def worker(number):
        ((_, process),) = engine.results(iter([Sleep(number, 0.0)]))
        return process

    with LocalWorkers(1) as engine:
        first = worker(0)
        assert worker(1) == first
    wait_for(lambda: not exist([first]))


def test_a_worker_that_was_killed_between_two_works_is_replaced():
    with LocalWorkers(1) as engine:
        assert list(engine.results(iter([Square(2)]))) == [(2, 4)]
        (worker,) = active_children()
        worker.kill()
        worker.join(DEADLINE)
        assert list(engine.results(iter([Square(3)]))) == [(3, 9)]


def test_workers_that_always_end_are_told_with_what_they_had_in_work(monkeypatch):
    monkeypatch.setattr(local_workers, "MOST_DEATHS", 0)
    told = "1 workers ended one after the other, at work on part 0"
    with LocalWorkers(1) as engine, pytest.raises(LoopError, match=told):
        list(engine.results(map(End, range(3))))


def test_what_a_job_raises_comes_through():
    refused = Refuse(3, BadInputError("is refused"))
    with LocalWorkers(1) as engine, pytest.raises(BadInputError, match=r"^is refused$"):
        list(engine.results(iter([refused])))


def test_whoever_stops_iterating_waits_for_nobody():
    durations = enumerate([0.0, DEADLINE, DEADLINE, DEADLINE])
    with LocalWorkers(2) as engine:
        results = engine.results(Sleep(*one) for one in durations)
        assert next(results)[0] == 0
        workers = [child.pid for child in active_children()]
        assert len(workers) == 2
        began = time.monotonic()
        results.close()
        assert time.monotonic() - began < 0.5 * DEADLINE
        wait_for(lambda: not exist(workers))


def test_jobs_are_asked_for_as_there_is_room():
    asked = []

    def jobs():
        for number in range(50):
            asked.append(number)
            yield Square(number)

    with LocalWorkers(1) as engine:
        next(engine.results(jobs()))
        assert len(asked) <= 4
