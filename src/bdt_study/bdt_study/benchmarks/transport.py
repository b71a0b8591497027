"""Benchmarks of the transport: what it takes to bring messages from one process to another.

Both ends are processes of their own in a ROS domain of their own, on the loopback interface. They
measure whichever rclpy is installed. The floor is the same ping-pong with bytes straight to
Cyclone DDS, where its Python package is installed.
"""

import time
from importlib.util import find_spec
from statistics import median

from bdt_study.benchmarks import processes
from bdt_study.benchmarks.processes import peer, result, time_of
from bdt_study.benchmarks.result import BenchmarkResult, BenchmarkSize, compared

TRANSPORT_NODE = "bdt_study.benchmarks.transport_node"
DDS_PARTICIPANT = "bdt_study.benchmarks.dds_participant"

NUMBERS_IN_6KB = 750
"""Numbers in a Float64MultiArray of 6 kB, a telemetry batch of 50 ms."""

DISCOVERIES = 5
STARTS = 5

START = "import rclpy; rclpy.init(); rclpy.create_node('bench_start').destroy_node()"


def pingpong_vs_raw(size: BenchmarkSize) -> list[BenchmarkResult]:
    """Count round trips of a JointState between two processes, beside those of bare bytes."""
    ours = _ping(TRANSPORT_NODE, [], size.messages)
    rate = size.messages / ours["seconds"]
    name, unit = "pingpong_vs_raw", "round trips/s"
    cpu = BenchmarkResult(name, 1e6 * ours["cpu"] / size.messages, "us CPU of one end", "none")
    if find_spec("cyclonedds") is None:
        return [BenchmarkResult(name, rate, unit, "skipped: no Python package cyclonedds"), cpu]
    raw = _ping(DDS_PARTICIPANT, [str(processes.domain())], size.messages)
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
        with peer(TRANSPORT_NODE, ["watch"]) as watcher:
            begun = time.time()
            with peer(TRANSPORT_NODE, ["appear"], wait=False):
                seen = result(watcher)["seen"]
        times.append(seen - begun)
        starts.append(time_of(["-c", START]))
    what = "start of a process with a node, alone"
    return [compared("discovery", median(times), "s", what, median(starts))]


def start_up(_size: BenchmarkSize) -> list[BenchmarkResult]:
    """Time a process that imports rclpy and creates a node, beside one that does nothing."""
    with_node, imported, bare = (
        median([time_of(["-c", program]) for _ in range(STARTS)])
        for program in (START, "import rclpy", "pass")
    )
    return [
        compared("start_up", with_node, "s", "Python alone", bare),
        compared("start_up", imported, "s with import rclpy only", "Python alone", bare),
    ]


def _ping(module: str, arguments: list[str], count: int) -> dict[str, float]:
    with (
        peer(module, ["echo", *arguments]),
        peer(module, ["ping", *arguments, str(count)], wait=False) as ping,
    ):
        return result(ping)


def _one_way(name: str, count: int, numbers: int) -> list[BenchmarkResult]:
    words = [str(count), str(numbers)]
    with (
        peer(TRANSPORT_NODE, ["take", *words]) as reader,
        peer(TRANSPORT_NODE, ["send", *words], wait=False) as writer,
    ):
        taken, sent = result(reader), result(writer)
    return [
        BenchmarkResult(name, count / taken["seconds"], "messages/s", "none"),
        BenchmarkResult(name, 1e6 * sent["cpu"] / count, "us CPU to send one", "none"),
        BenchmarkResult(name, 1e6 * taken["cpu"] / count, "us CPU to take one", "none"),
    ]
