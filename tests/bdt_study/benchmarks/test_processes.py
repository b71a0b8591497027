"""Processes of the benchmarks stay on the loopback interface and are quoted when they fail."""

import os
import time

import pytest

from bdt_study.benchmarks import processes
from bdt_study.benchmarks.processes import ProcessError
from bdt_study.benchmarks.transport import TRANSPORT_NODE


def test_an_end_that_fails_is_quoted():
    with (
        processes.peer(TRANSPORT_NODE, ["nonsense"], wait=False) as peer,
        pytest.raises(ProcessError, match="KeyError: 'nonsense'"),
    ):
        processes.result(peer)


def test_a_program_that_fails_is_quoted():
    with pytest.raises(ProcessError, match=r"^ValueError: no$"):
        processes.time_of(["-c", "raise ValueError('no')"])


def test_a_program_that_says_nothing_is_told_of():
    with pytest.raises(ProcessError, match="without a word"):
        processes.output_of(["-c", "raise SystemExit(1)"])


DEAF_AND_DUMB = """
import signal, sys, time
signal.signal(signal.SIGTERM, signal.SIG_IGN)
if "speak" in sys.argv:
    print("ready", flush=True)
time.sleep(1000)
"""


@pytest.fixture
def deaf_and_dumb(tmp_path, monkeypatch):
    """Return the name of a module that ignores SIGTERM and says no more than "ready"."""
    (tmp_path / "deaf_and_dumb.py").write_text(DEAF_AND_DUMB)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    return "deaf_and_dumb"


def test_an_end_that_misses_its_signal_is_killed(deaf_and_dumb, monkeypatch):
    (ask, _), kill = processes.STOP_DEADLINES
    monkeypatch.setattr(processes, "STOP_DEADLINES", ((ask, 0.2), kill))
    begun = time.monotonic()
    with processes.peer(deaf_and_dumb, ["speak"]) as peer:
        pass
    assert peer.returncode == -kill[0]
    assert time.monotonic() - begun < 20.0


def test_an_end_that_does_not_answer_is_an_error_after_a_limited_time(deaf_and_dumb, monkeypatch):
    monkeypatch.setattr(processes, "TIMEOUT", 0.2)
    with (
        processes.peer(deaf_and_dumb, ["speak"]) as peer,
        pytest.raises(ProcessError, match=r"deaf_and_dumb speak: says nothing for 0\.2 s"),
    ):
        processes.result(peer)
    monkeypatch.setattr(processes, "READY_TIMEOUT", 0.2)
    with (
        pytest.raises(ProcessError, match=r"deaf_and_dumb: says nothing for 0\.2 s"),
        processes.peer(deaf_and_dumb, []),
    ):
        pass


def test_a_program_that_does_not_end_is_an_error_after_a_limited_time(monkeypatch):
    monkeypatch.setattr(processes, "TIMEOUT", 0.2)
    with pytest.raises(ProcessError, match=r"sleep\(1000\): is not done within 0\.2 s"):
        processes.time_of(["-c", "import time; time.sleep(1000)"])


def test_both_ends_stay_on_the_loopback_interface():
    environment = processes.environment()
    assert environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    assert "name='lo' multicast='false'" in environment["CYCLONEDDS_URI"]
