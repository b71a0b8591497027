"""Processes of the benchmarks: their ROS domain, what they answer, how one that fails is quoted."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, cast

from bdt_msgs_py.command_errors import LoopError
from bdt_msgs_py.process_end import ProcessEnd

TIMEOUT = 300.0
"""Wall time after which a benchmark has failed [s]."""

READY_TIMEOUT = 60.0
"""Wall time within which an end must be ready for the other one [s]."""

STOP_DEADLINES = ((signal.SIGTERM, 5.0), (signal.SIGKILL, 5.0))
"""Signals that end an end of a benchmark, and the time each one has to work [s]."""

LOOPBACK = (
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='lo' multicast='false'/>"
    "</Interfaces><AllowMulticast>false</AllowMulticast></General><Discovery><Peers>"
    "<Peer address='127.0.0.1'/></Peers><ParticipantIndex>auto</ParticipantIndex>"
    "<MaxAutoParticipantIndex>50</MaxAutoParticipantIndex></Discovery></Domain></CycloneDDS>"
)
"""Configuration of Cyclone DDS for the floor, which has no rclpy to pin it to the loopback."""


class ProcessError(LoopError):
    """A process of a benchmark failed; the text is what it said last."""


def output_of(arguments: Sequence[str]) -> str:
    """Run Python with some arguments to its end and return its standard output.

    Raises
    ------
    ProcessError
        If its exit code is not 0, or it does not end.
    """
    try:
        done = subprocess.run(  # noqa: S603 - our own program
            [sys.executable, *arguments],
            check=False,
            env=environment(),
            capture_output=True,
            text=True,
            timeout=TIMEOUT,
        )
    except subprocess.TimeoutExpired:
        words = " ".join(arguments[1:])
        raise ProcessError(f"{words}: is not done within {TIMEOUT:g} s") from None
    if done.returncode:
        raise ProcessError(_last_line(done.stderr))
    return done.stdout


def time_of(arguments: Sequence[str]) -> float:
    """Return how long Python with some arguments runs [s].

    Raises
    ------
    ProcessError
        If its exit code is not 0.
    """
    begun = time.perf_counter()
    output_of(arguments)
    return time.perf_counter() - begun


@contextmanager
def peer(
    module: str, arguments: Sequence[str], *, wait: bool = True
) -> Iterator["subprocess.Popen[str]"]:
    """Start an end of a benchmark, wait until it is ready, and end it afterwards."""
    with subprocess.Popen(  # noqa: S603 - our own program
        [sys.executable, "-m", module, *arguments],
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            if wait:
                _line(process, READY_TIMEOUT)
            yield process
        finally:
            # A signal may find a node before or between its handlers and get lost.
            ProcessEnd(process, STOP_DEADLINES).wait()


def result(process: "subprocess.Popen[str]") -> dict[str, Any]:
    """Return the numbers that an end of a benchmark prints.

    Raises
    ------
    ProcessError
        If it ends, or has to be ended, without them.
    """
    numbers: dict[str, Any] = json.loads(_line(process, TIMEOUT))
    return numbers


def domain() -> int:
    """Return the ROS domain of the benchmarks of this process."""
    return 1 + os.getpid() % 100


def environment() -> Mapping[str, str]:
    """Return the environment of both ends: a ROS domain of their own, nothing but loopback."""
    return {
        **os.environ,
        "ROS_DOMAIN_ID": str(domain()),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "CYCLONEDDS_URI": LOOPBACK,
    }


def _line(process: "subprocess.Popen[str]", timeout: float) -> str:
    """Return the next line of a process, which is ended when none comes within `timeout` [s]."""
    limit = threading.Timer(timeout, process.kill)
    limit.start()
    try:
        line = process.stdout.readline() if process.stdout else ""
        if line:
            return line
        said = process.communicate()[1]
    finally:
        timed_out = not limit.is_alive()
        limit.cancel()
        limit.join()
    if timed_out:
        words = " ".join(cast("list[str]", process.args)[2:])
        raise ProcessError(f"{words}: says nothing for {timeout:g} s")
    raise ProcessError(_last_line(said))


def _last_line(text: str) -> str:
    return (text.strip().splitlines() or ["a process ended without a word"])[-1]
