"""Benchmarks of the transport: what it takes to bring messages from one process to another.

Both ends are processes of their own in a ROS domain of their own, on the loopback interface. They
measure whichever rclpy is installed. The floor is the same ping-pong with bytes straight to
Cyclone DDS, where its Python package is installed.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from statistics import median

from bdt_bringup.benchmarks.result import BenchmarkResult, BenchmarkSize, compared
from bdt_msgs_py.exit_codes import LoopError

ROS_PEER = "bdt_bringup.benchmarks.ros_peer"
RAW_PEER = "bdt_bringup.benchmarks.raw_peer"

NUMBERS_IN_6KB = 750
"""Numbers in a Float64MultiArray of 6 kB, a telemetry batch of 50 ms."""

PATIENCE = 300.0
"""Wall time after which a benchmark has failed [s]."""

DISCOVERIES = 5
STARTS = 5

SINGLE = ["--processes", "single"]

CONTROL_RATE = 500.0
"""Control rate of the default configuration [Hz]."""

LOOPBACK = (
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='lo' multicast='false'/>"
    "</Interfaces><AllowMulticast>false</AllowMulticast></General><Discovery><Peers>"
    "<Peer address='127.0.0.1'/></Peers><ParticipantIndex>auto</ParticipantIndex>"
    "<MaxAutoParticipantIndex>50</MaxAutoParticipantIndex></Discovery></Domain></CycloneDDS>"
)
"""Configuration of Cyclone DDS for the floor, which has no rclpy to pin it to the loopback."""

START = "import rclpy; rclpy.init(); rclpy.create_node('bench_start').destroy_node()"


class TransportError(LoopError):
    """An end of a benchmark failed; the text is what it said last."""


def pingpong_vs_raw(size: BenchmarkSize) -> list[BenchmarkResult]:
    """Count round trips of a JointState between two processes, beside those of bare bytes."""
    ours = _ping(ROS_PEER, [], size.messages)
    rate = size.messages / ours["seconds"]
    name, unit = "pingpong_vs_raw", "round trips/s"
    cpu = BenchmarkResult(name, 1e6 * ours["cpu"] / size.messages, "us CPU of one end", "none")
    if find_spec("cyclonedds") is None:
        return [BenchmarkResult(name, rate, unit, "skipped: no Python package cyclonedds"), cpu]
    raw = _ping(RAW_PEER, [str(_domain())], size.messages)
    floor = size.messages / raw["seconds"]
    return [compared(name, rate, unit, "bytes straight to Cyclone DDS", floor), cpu]


def one_way_joint_state(size: BenchmarkSize) -> list[BenchmarkResult]:
    """Count JointStates that one process sends and another takes, none lost."""
    return _one_way("one_way_joint_state", size.messages, 0)


def one_way_6kb(size: BenchmarkSize) -> list[BenchmarkResult]:
    """Count arrays of 750 numbers that one process sends and another takes, none lost."""
    return _one_way("one_way_6kb", size.messages, NUMBERS_IN_6KB)


def discovery(_size: BenchmarkSize) -> list[BenchmarkResult]:
    """Time from the start of a process until another one sees its node in the graph."""
    times, starts = [], []
    for _ in range(DISCOVERIES):
        with _peer(ROS_PEER, ["watch"]) as watcher:
            begun = time.time()
            with _peer(ROS_PEER, ["appear"], wait=False):
                seen = _result(watcher)["seen"]
        times.append(seen - begun)
        starts.append(_start_time(START))
    what = "start of a process with a node, alone"
    return [compared("discovery", median(times), "s", what, median(starts))]


def start_up(_size: BenchmarkSize) -> list[BenchmarkResult]:
    """Time a process that imports rclpy and creates a node, beside one that does nothing."""
    with_node, imported, bare = (
        median([_start_time(program) for _ in range(STARTS)])
        for program in (START, "import rclpy", "pass")
    )
    return [
        compared("start_up", with_node, "s", "Python alone", bare),
        compared("start_up", imported, "s with import rclpy only", "Python alone", bare),
    ]


def lockstep_real_time_factor(size: BenchmarkSize) -> list[BenchmarkResult]:
    """Run the paper's loop in processes of their own with a bag, in one process, and without."""
    separate, single, unrecorded = (
        _loop_factor(size.loop_duration, options) for options in ([], SINGLE, ["--no-bag"])
    )
    name = "lockstep_real_time_factor"
    what = "all nodes in one process"
    return [
        compared(name, separate, "simulated s/s", what, single),
        compared(name, CONTROL_RATE * separate, "ticks/s", what, CONTROL_RATE * single),
        compared(
            name, CONTROL_RATE * separate, "ticks/s", "no recorder", CONTROL_RATE * unrecorded
        ),
    ]


def _ping(module: str, arguments: list[str], count: int) -> dict[str, float]:
    with (
        _peer(module, ["echo", *arguments]),
        _peer(module, ["ping", *arguments, str(count)], wait=False) as ping,
    ):
        return _result(ping)


def _one_way(name: str, count: int, numbers: int) -> list[BenchmarkResult]:
    words = [str(count), str(numbers)]
    with (
        _peer(ROS_PEER, ["take", *words]) as reader,
        _peer(ROS_PEER, ["send", *words], wait=False) as writer,
    ):
        taken, sent = _result(reader), _result(writer)
    return [
        BenchmarkResult(name, count / taken["seconds"], "messages/s", "none"),
        BenchmarkResult(name, 1e6 * sent["cpu"] / count, "us CPU to send one", "none"),
        BenchmarkResult(name, 1e6 * taken["cpu"] / count, "us CPU to take one", "none"),
    ]


def _loop_factor(duration: float, options: list[str]) -> float:
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "bdt_bringup.cli", "run", "--json"]
        command += ["--duration", str(duration), "--output", str(Path(folder) / "run"), *options]
        done = subprocess.run(  # noqa: S603 - our own program
            command,
            check=False,
            env=_environment(),
            capture_output=True,
            text=True,
            timeout=PATIENCE,
        )
    if done.returncode:
        raise TransportError(_last_line(done.stderr))
    return float(json.loads(done.stdout)["real_time_factor"])


def _start_time(program: str) -> float:
    begun = time.perf_counter()
    subprocess.run(  # noqa: S603 - our own program
        [sys.executable, "-c", program], env=_environment(), check=True, timeout=PATIENCE
    )
    return time.perf_counter() - begun


@contextmanager
def _peer(
    module: str, arguments: list[str], *, wait: bool = True
) -> Iterator["subprocess.Popen[str]"]:
    """Start an end of a benchmark, wait until it is ready, and end it afterwards."""
    with subprocess.Popen(  # noqa: S603 - our own program
        [sys.executable, "-m", module, *arguments],
        env=_environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            if wait:
                _line(process)
            yield process
        finally:
            process.terminate()


def _result(process: "subprocess.Popen[str]") -> dict[str, float]:
    numbers: dict[str, float] = json.loads(_line(process))
    return numbers


def _line(process: "subprocess.Popen[str]") -> str:
    """Return the next line of a process; it cannot hang longer than its other end lives."""
    line = process.stdout.readline() if process.stdout else ""
    if not line:
        raise TransportError(_last_line(process.communicate(timeout=PATIENCE)[1]))
    return line


def _last_line(text: str) -> str:
    return (text.strip().splitlines() or ["a process ended without a word"])[-1]


def _domain() -> int:
    return 1 + os.getpid() % 100


def _environment() -> Mapping[str, str]:
    """Return the environment of both ends: a ROS domain of their own, nothing but loopback."""
    return {
        **os.environ,
        "ROS_DOMAIN_ID": str(_domain()),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "CYCLONEDDS_URI": LOOPBACK,
    }
