"""Workers: every job is done once, whoever is killed; nobody outlives whoever gave the work."""

import os
import signal
import time
from multiprocessing import active_children
from pathlib import Path

import pytest

from bdt_msgs_py.command_errors import BadInputError, LoopError
from bdt_study.simulation import worker_pool
from bdt_study.simulation.worker_pool import WorkerPool

DEADLINE = 60.0

WORK = """
import os
import time

def square(job):
    return job * job

def refuse(job):
    from bdt_msgs_py.command_errors import BadInputError
    raise BadInputError(f"job {job} is refused")

def end(job):
    os._exit(1)

def sleep(job):
    time.sleep(job)
    return job
"""


@pytest.fixture
def work(tmp_path, monkeypatch):
    """Return functions that a new process can import without all of this project."""
    (tmp_path / "quick_work.py").write_text(WORK)
    monkeypatch.syspath_prepend(str(tmp_path))
    import quick_work

    return quick_work


def wait_for(condition):
    end = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_every_job_is_done_once_though_workers_are_killed(work):
    done = []
    for job, result in WorkerPool(work.square, 2).results(iter(range(200))):
        assert result == job * job
        done.append(job)
        if len(done) in (1, 100):
            os.kill(active_children()[0].pid, signal.SIGKILL)
    assert sorted(done) == list(range(200))


def test_results_in_order_wait_for_those_before_them(work):
    jobs = [0.5, 0.0, 0.1, 0.0]
    assert list(WorkerPool(work.sleep, 2).in_order(iter(jobs))) == jobs


def test_workers_that_always_end_are_told_with_what_they_had_in_work(work, monkeypatch):
    monkeypatch.setattr(worker_pool, "MOST_DEATHS", 0)
    pool = WorkerPool(work.end, 1, describe=lambda job: f"part {job}")
    with pytest.raises(LoopError, match="1 workers ended one after the other, at work on part 0"):
        list(pool.results(iter([0, 1, 2])))


def test_what_the_work_raises_comes_through(work):
    with pytest.raises(BadInputError, match="job 3 is refused"):
        list(WorkerPool(work.refuse, 1).results(iter([3])))


def test_whoever_stops_iterating_waits_for_nobody(work):
    results = WorkerPool(work.sleep, 2).results(iter([0.0, DEADLINE, DEADLINE, DEADLINE]))
    assert next(results) == (0.0, 0.0)
    workers = [child.pid for child in active_children()]
    assert len(workers) == 2
    began = time.monotonic()
    results.close()
    assert time.monotonic() - began < 0.5 * DEADLINE
    wait_for(lambda: not any(Path(f"/proc/{pid}").exists() for pid in workers))


def test_jobs_are_asked_for_as_there_is_room(work):
    asked = []

    def jobs():
        for job in range(50):
            asked.append(job)
            yield job

    results = WorkerPool(work.square, 1).results(jobs())
    next(results)
    assert len(asked) <= 4
    results.close()
