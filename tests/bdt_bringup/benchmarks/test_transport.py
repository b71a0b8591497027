"""Benchmarks of the transport: two processes, every message arrives, numbers that make sense."""

import subprocess
import sys
from importlib.util import find_spec

import pytest

from bdt_bringup.benchmarks import transport
from bdt_bringup.benchmarks.result import BenchmarkSize

TINY = BenchmarkSize(messages=200, loop_duration=1.0)


def test_the_ping_pong_stands_beside_bare_bytes():
    rate, cpu = transport.pingpong_vs_raw(TINY)
    assert rate.unit == "round trips/s"
    assert rate.value > 10
    assert cpu.value > 0
    if find_spec("cyclonedds") is None:
        assert rate.reference.startswith("skipped")
    else:
        assert rate.ratio == pytest.approx(rate.value / rate.reference_value)


@pytest.mark.parametrize("benchmark", [transport.one_way_joint_state, transport.one_way_6kb])
def test_messages_go_one_way(benchmark):
    rate, sending, taking = benchmark(TINY)
    assert rate.name == benchmark.__name__
    assert rate.unit == "messages/s"
    assert min(rate.value, sending.value, taking.value) > 0


def test_a_node_is_discovered(monkeypatch):
    monkeypatch.setattr(transport, "DISCOVERIES", 1)
    (result,) = transport.discovery(TINY)
    assert 0 < result.value < 30


def test_starting_with_rclpy_takes_longer_than_without(monkeypatch):
    monkeypatch.setattr(transport, "STARTS", 1)
    with_node, imported = transport.start_up(TINY)
    assert with_node.ratio > 1
    assert imported.value < with_node.value


def test_the_loop_is_compared_with_one_process_and_with_no_recorder(monkeypatch):
    paces = {(): 6.0, ("--processes", "single"): 8.0, ("--no-bag",): 12.0}
    monkeypatch.setattr(transport, "_loop_factor", lambda _, options: paces[tuple(options)])
    factor, ticks, recorded = transport.lockstep_real_time_factor(TINY)
    assert (factor.value, factor.reference_value, factor.ratio) == (6.0, 8.0, 0.75)
    assert (ticks.value, ticks.reference_value, ticks.ratio) == (3000.0, 4000.0, 0.75)
    assert (recorded.value, recorded.reference_value, recorded.ratio) == (3000.0, 6000.0, 0.5)


def test_the_pace_of_the_loop_is_that_of_a_run():
    assert transport._loop_factor(1.0, transport.SINGLE) > 0


def test_a_loop_that_fails_is_quoted():
    with pytest.raises(transport.TransportError, match="invalid choice: 'warp'"):
        transport._loop_factor(1.0, ["--mode", "warp"])


def test_an_end_that_fails_is_quoted():
    with (
        transport._peer(transport.ROS_PEER, ["nonsense"], wait=False) as peer,
        pytest.raises(transport.TransportError, match="KeyError: 'nonsense'"),
    ):
        transport._result(peer)


def test_the_ends_stay_on_the_loopback_interface():
    environment = transport._environment()
    assert environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    assert "name='lo' multicast='false'" in environment["CYCLONEDDS_URI"]


def test_the_offline_benchmarks_need_no_rclpy():
    program = "import bdt_bringup.benchmarks.bench, sys; sys.exit('rclpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], check=False, timeout=60)
    assert done.returncode == 0
