"""How much processes let others go first."""

import os
import subprocess
import sys

import pytest

from bdt_live.niceness import REPORT_NICENESS, let_others_go_first

MOST = 19


@pytest.fixture
def waiting():
    with subprocess.Popen(
        [sys.executable, "-c", "input()"], stdin=subprocess.PIPE, stderr=subprocess.DEVNULL
    ) as process:
        yield process
        process.stdin.close()


def test_a_process_becomes_nicer_and_never_less_nice(waiting):
    ours = os.getpriority(os.PRIO_PROCESS, 0)
    let_others_go_first(waiting.pid, REPORT_NICENESS)
    assert os.getpriority(os.PRIO_PROCESS, waiting.pid) == max(ours, REPORT_NICENESS)
    let_others_go_first(waiting.pid, MOST)
    let_others_go_first(waiting.pid, REPORT_NICENESS)
    assert os.getpriority(os.PRIO_PROCESS, waiting.pid) == MOST
    assert os.getpriority(os.PRIO_PROCESS, 0) == ours
