"""Real-time execution: what a process gets, what it is refused, when garbage is collected."""

import gc
import json
import subprocess
import sys

import pytest

from bdt_msgs_py.real_time import RealTimeSettings, collect_due_garbage

CHILD = """
import ctypes, gc, json, os, resource, sys, threading
from pathlib import Path
from bdt_msgs_py.real_time import RealTimeSettings, enter_real_time

PR_SET_DUMPABLE = 4
awaited = threading.Event()
threading.Thread(target=awaited.wait, daemon=True).start()
if sys.argv[1] == "refused":
    for limit in (resource.RLIMIT_RTPRIO, resource.RLIMIT_MEMLOCK):
        resource.setrlimit(limit, (0, 0))
    if os.getuid() == 0:
        os.setuid(65534)
        ctypes.CDLL(None).prctl(PR_SET_DUMPABLE, 1)  # /proc/self is its own again
refusals = enter_real_time(RealTimeSettings(3, lock_memory=True, collect_in_slack=True))
status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
tasks = [int(task) for task in os.listdir("/proc/self/task")]
print(json.dumps({
    "refusals": refusals,
    "fifo": [os.sched_getscheduler(task) == os.SCHED_FIFO for task in tasks],
    "priority": os.sched_getparam(0).sched_priority,
    "locked": int(status["VmLck"].split()[0]) > 0,
    "collects": gc.isenabled(),
    "frozen": gc.get_freeze_count() > 1000,
}))
"""


def child(way):
    command = [sys.executable, "-c", CHILD, way]
    done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=60)
    return json.loads(done.stdout)


def test_a_process_gets_priority_in_all_its_threads_and_its_memory_locked():
    told = child("granted")
    if told["refusals"]:
        pytest.skip(told["refusals"][0])
    assert told["fifo"] == [True, True]
    assert told["priority"] == 3
    assert told["locked"]


def test_what_is_refused_is_told_with_what_to_do_and_the_process_goes_on():
    told = child("refused")
    priority, memory = told["refusals"]
    assert priority.startswith("real_time.priority = 3: refused, this user may have 0; allow it")
    assert memory.startswith("real_time.lock_memory: refused, this user may lock 0 bytes; allow")
    assert told["fifo"] == [False, False]
    assert not told["locked"]


def test_what_is_there_at_the_start_is_never_collected_and_nothing_is_by_itself():
    told = child("refused")
    assert told["frozen"]
    assert not told["collects"]


def test_without_being_asked_a_process_stays_as_it_is():
    program = (
        "from bdt_msgs_py.real_time import *; import gc, os\n"
        "assert enter_real_time(RealTimeSettings()) == []\n"
        "assert gc.isenabled() and os.sched_getscheduler(0) == os.SCHED_OTHER"
    )
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)


@pytest.mark.parametrize("priority", [-1, 100])
def test_a_priority_that_linux_does_not_know_is_refused(priority):
    with pytest.raises(ValueError, match=rf"priority = {priority}: must be 0 to 99"):
        RealTimeSettings(priority)


@pytest.fixture
def leave_to_us():
    gc.collect()
    gc.disable()
    yield
    gc.enable()


@pytest.mark.usefixtures("leave_to_us")
def test_garbage_is_collected_when_python_would_have_collected_it():
    collect_due_garbage()
    collected = [generation["collections"] for generation in gc.get_stats()]
    cycles = []
    while gc.get_count()[0] <= gc.get_threshold()[0]:
        cycles.append([cycles])
    assert [generation["collections"] for generation in gc.get_stats()] == collected
    collect_due_garbage()
    assert gc.get_stats()[0]["collections"] == collected[0] + 1
    assert gc.get_count()[0] <= gc.get_threshold()[0]
    collect_due_garbage()
    assert gc.get_stats()[0]["collections"] == collected[0] + 1


@pytest.mark.usefixtures("leave_to_us")
def test_every_generation_has_its_turn():
    before = [generation["collections"] for generation in gc.get_stats()]
    younger, older = gc.get_threshold()[1:]
    kept = []
    for _ in range((younger + 2) * (older + 2)):
        while gc.get_count()[0] <= gc.get_threshold()[0]:
            kept.append([])
        collect_due_garbage()
    after = [generation["collections"] for generation in gc.get_stats()]
    assert all(later > earlier for earlier, later in zip(before, after, strict=True))
