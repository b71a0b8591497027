"""Many schedules of faults, as `make soak` runs them."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

SOAK = Path(__file__).with_name("soak.py")


def test_an_interrupted_soak_leaves_no_process_and_knows_what_has_run(tmp_path):
    results = tmp_path / "results.txt"
    soak = subprocess.Popen(
        [sys.executable, SOAK, "--count", "9", "--jobs", "2", "--results", results],
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    said = soak.stdout.readline()
    assert ": recovered: " in said
    soak.send_signal(signal.SIGTERM)
    assert soak.wait(30.0) == 130
    soak.stdout.close()
    end = time.monotonic() + 10.0
    while group_lives(soak.pid):
        assert time.monotonic() < end, "processes are left"
        time.sleep(0.05)
    seed = said.partition(":")[0]
    assert results.read_text().splitlines()[0] == f"{seed} recovered"


WORKER = """
import soak

soak.claim()
try:
    soak.outcome_of(0, False)
except BaseException:
    pass
print("goes on")
"""
"""What a worker of a pool does: whatever is thrown is a result for it."""
TOLD_AT_ONCE = """
import os
import signal
import soak
import forked_node

start = forked_node._CONTEXT.Process.start

def start_and_be_told(process):
    start(process)
    os.kill(os.getpid(), signal.SIGTERM)

forked_node._CONTEXT.Process.start = start_and_be_told
"""
"""Has it be told to end when it has started a node and not taken note of it yet."""
TOLD_AT_THE_END = """
import os
import signal
import soak
import forked_node

kill = forked_node.ForkedNode.kill

def be_told_and_kill(node):
    os.kill(os.getpid(), signal.SIGTERM)
    kill(node)

forked_node.ForkedNode.kill = be_told_and_kill
"""
"""Has it be told to end while it ends the nodes of a loop that is over."""


def test_a_worker_that_is_told_to_end_does_not_go_on(tmp_path):
    """One that went on waited for work that never came, when another had ended before it."""
    worker = worker_that_runs(WORKER, tmp_path)
    end = time.monotonic() + 30.0
    while not list(tmp_path.glob("faults-*/*.log")):
        assert time.monotonic() < end, "no loop begins"
        time.sleep(0.05)
    worker.send_signal(signal.SIGTERM)
    ends_and_leaves_nothing(worker, tmp_path)


@pytest.mark.parametrize("moment", [TOLD_AT_ONCE, TOLD_AT_THE_END], ids=["starts", "ends"])
def test_a_worker_that_is_told_to_end_while_it_starts_or_ends_a_loop_leaves_no_node(
    moment, tmp_path
):
    ends_and_leaves_nothing(worker_that_runs(moment + WORKER, tmp_path), tmp_path)


def worker_that_runs(code, folder):
    """Return a process with a group of its own, whose loops are in a folder."""
    return subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(SOAK.parent), "TMPDIR": str(folder)},
        start_new_session=True,
    )


def ends_and_leaves_nothing(worker, tmp_path):
    """Check that a worker ends as one that was told to, with all that it has started."""
    said, _ = worker.communicate(timeout=30.0)
    assert (worker.returncode, said) == (130, "")
    assert not list(tmp_path.glob("faults-*")), "its loop is left"
    end = time.monotonic() + 10.0
    while group_lives(worker.pid):
        assert time.monotonic() < end, "processes are left"
        time.sleep(0.05)


def group_lives(group):
    """Tell whether a process of a group is there."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True
