"""Estimation in a thread of its own: order, faults, lag, end."""

import threading

import numpy as np
import pytest

from bdt_twin.estimation_thread import LARGEST_BACKLOG, EstimationThread
from bdt_twin.estimator import Estimate, TelemetryRejectedError

DEADLINE = 60.0


class Recorder:
    """An estimator that notes what it gets and waits until it is let go."""

    def __init__(self):
        self.batches, self.newest_only = [], []
        self.go = threading.Event()
        self.go.set()
        self.busy = threading.Event()

    def restart(self):
        pass

    def update(self, batch, *, newest_only=False):
        self.busy.set()
        assert self.go.wait(DEADLINE)
        self.batches.append(batch[:, 0].tolist())
        self.newest_only.append(newest_only)
        if np.isnan(batch).any():
            raise TelemetryRejectedError("row 0 is not finite")
        if batch[0, 1] == 13.0:
            raise ZeroDivisionError("a bug")
        return Estimate(float(batch[-1, 0]), 0.1)


class Collector:
    """Collects outcomes as a node does when it is notified."""

    def __init__(self, estimator):
        self.notified = threading.Semaphore(0)
        self.thread = EstimationThread(estimator, self.notified.release)
        self.outcomes = []

    def collect(self, count):
        while len(self.outcomes) < count:
            assert self.notified.acquire(timeout=DEADLINE)
            self.outcomes += self.thread.outcomes()
        return self.outcomes


@pytest.fixture
def estimator():
    return Recorder()


@pytest.fixture
def collector(estimator):
    collector = Collector(estimator)
    yield collector
    estimator.go.set()
    collector.thread.close()


def rows(*times, voltage=0.0):
    return np.array([[time, voltage, 0.0] for time in times])


def test_every_batch_has_an_outcome_in_its_order(estimator, collector):
    for start in range(5):
        collector.thread.put(rows(start, start + 0.5))
    outcomes = collector.collect(5)
    assert [outcome.newest for outcome in outcomes] == [0.5, 1.5, 2.5, 3.5, 4.5]
    assert [outcome.estimate.time for outcome in outcomes] == [0.5, 1.5, 2.5, 3.5, 4.5]
    assert {outcome.samples for outcome in outcomes} == {2}
    assert not any(outcome.begins or outcome.fault for outcome in outcomes)


def test_whoever_hands_over_never_waits_for_the_estimator(estimator, collector):
    estimator.go.clear()
    for start in range(4):
        collector.thread.put(rows(start))
    assert estimator.busy.wait(DEADLINE)
    assert collector.thread.outcomes() == []
    estimator.go.set()
    assert len(collector.collect(4)) == 4


def test_what_waits_too_long_is_taken_in_one_go(estimator, collector):
    estimator.go.clear()
    collector.thread.put(rows(0.0))
    assert estimator.busy.wait(DEADLINE)
    for start in np.arange(1.0, LARGEST_BACKLOG + 3.0):
        collector.thread.put(rows(start))
    estimator.go.set()
    first, second = collector.collect(2)
    assert (first.newest, second.newest) == (0.0, LARGEST_BACKLOG + 2.0)
    assert estimator.batches[1] == np.arange(1.0, LARGEST_BACKLOG + 3.0).tolist()
    assert estimator.newest_only == [False, True]


def test_what_waits_no_longer_than_lockstep_allows_is_worked_on_batch_by_batch(
    estimator, collector
):
    estimator.go.clear()
    for start in np.arange(0.0, LARGEST_BACKLOG, 0.5):
        collector.thread.put(rows(start))
    estimator.go.set()
    assert len(collector.collect(10)) == 10


def test_a_rejected_batch_is_an_outcome_that_says_why(collector):
    collector.thread.put(rows(np.nan))
    collector.thread.put(rows(1.0))
    bad, good = collector.collect(2)
    assert bad.fault == "row 0 is not finite"
    assert bad.estimate is None
    assert good.fault == ""


def test_time_that_goes_back_begins_another_run(collector):
    collector.thread.put(rows(7.0, 8.0))
    collector.thread.put(rows(np.nan))
    collector.thread.put(rows(1.0, 2.0))
    assert [outcome.begins for outcome in collector.collect(3)] == [False, False, True]


def test_a_bug_of_the_estimator_reaches_whoever_collects(collector):
    collector.thread.put(rows(1.0, voltage=13.0))
    with pytest.raises(ZeroDivisionError, match="a bug"):
        collector.collect(1)


def test_closing_ends_the_thread_and_leaves_the_rest():
    collector = Collector(Recorder())
    collector.thread.put(rows(1.0))
    collector.collect(1)
    collector.thread.close()
    assert "estimation" not in {thread.name for thread in threading.enumerate()}


def test_an_estimator_that_hangs_does_not_keep_anybody_from_the_end(estimator, monkeypatch):
    monkeypatch.setattr("bdt_twin.estimation_thread.LONGEST_END", 0.05)
    estimator.go.clear()
    thread = EstimationThread(estimator, lambda: None)
    thread.put(np.zeros((1, 3)))
    assert estimator.busy.wait(DEADLINE)
    closing = threading.Thread(target=thread.close)
    closing.start()
    closing.join(DEADLINE / 2)
    ended = not closing.is_alive()
    estimator.go.set()
    closing.join()
    assert ended
