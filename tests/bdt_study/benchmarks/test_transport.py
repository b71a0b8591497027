"""Benchmarks of the transport: two processes, every message arrives, numbers that make sense."""

import json
import subprocess
import sys
from importlib.util import find_spec

import pytest

from bdt_study.benchmarks import transport
from bdt_study.benchmarks.bench import run_benchmarks
from bdt_study.benchmarks.result import BenchmarkSize

TINY = BenchmarkSize(messages=200, loop_duration=1.0)


def test_the_ping_pong_stands_beside_bare_bytes_in_the_json_of_all_benchmarks():
    report = json.loads(json.dumps(run_benchmarks(["pingpong_vs_raw"], TINY), allow_nan=False))
    rate, cpu = report["results"]
    assert rate["name"] == cpu["name"] == "pingpong_vs_raw"
    assert rate["unit"] == "round trips/s"
    assert rate["value"] > 10
    assert cpu["value"] > 0
    if find_spec("cyclonedds") is None:
        assert rate["reference"].startswith("skipped")
    else:
        assert rate["ratio"] == pytest.approx(rate["value"] / rate["reference_value"])


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


def test_the_offline_benchmarks_need_no_rclpy():
    program = "import bdt_study.benchmarks.bench, sys; sys.exit('rclpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], check=False, timeout=60)
    assert done.returncode == 0
