"""`bdt` as a process, the nodes that it starts, and what to wait for."""

import os
import subprocess
import sys
import time
from pathlib import Path

DEADLINE = 180.0
ONE_SECOND = 250_000
"""Size of the recording of a second [byte]."""


def bdt(*arguments, domain=None):
    chosen = {} if domain is None else {"ROS_DOMAIN_ID": str(domain)}
    return subprocess.Popen(
        [sys.executable, "-m", "bdt_bringup.cli", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | chosen,
    )


def finished(process):
    out, err = process.communicate(timeout=DEADLINE)
    return process.returncode, out, err


def wait_for(condition, what):
    end = time.monotonic() + DEADLINE
    while not (result := condition()):
        assert time.monotonic() < end, what
        time.sleep(0.02)
    return result


def children(pid):
    """Return the nodes that `bdt run` started: name and process identifier."""
    nodes = {}
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            parent = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
            words = (entry / "cmdline").read_text().split("\0")
        except (FileNotFoundError, ProcessLookupError):
            continue
        if parent == pid and "bdt_bringup.child_node" in words:
            nodes[words[4].rsplit(".", 1)[1].removesuffix("_node")] = int(entry.name)
    return nodes


def wait_for_the_loop(process, output):
    """Wait until the loop has run for about a second of simulated time: the bag grows."""

    def running():
        assert process.poll() is None, process.communicate()[1]
        return sum(file.stat().st_size for file in output.glob("bag/*")) > ONE_SECOND

    wait_for(running, "the loop runs")


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True
