"""The loop in real time: what counts as missed, what it stands beside, and that it runs."""

import time
from importlib.util import find_spec

import numpy as np
import pytest
import yaml

from bdt_bringup.cli import run_command
from bdt_bringup.configuration import load_configuration
from bdt_study.benchmarks import real_time
from bdt_study.benchmarks.paced_timer import periods
from bdt_study.benchmarks.real_time import Series, answered
from bdt_study.benchmarks.result import BenchmarkSize

pytestmark = pytest.mark.real_time

BRIEF = BenchmarkSize(real_time_duration=0.5)
RATE = 500.0


def test_a_drive_s_times_give_the_answers_and_the_periods_without_one():
    readings = np.arange(1000, dtype=np.int64) * 2_000_000
    times = np.column_stack((readings, readings + 250_000))
    kept = np.delete(times, [600, 601, 700], axis=0)  # after the half second of warming up
    series = answered(kept, RATE)
    assert series.missed == 3
    assert len(series.times) == 750 - 3
    np.testing.assert_allclose(series.times, 250.0)


def test_work_that_takes_too_long_costs_the_periods_that_are_over():
    lateness = []
    for late in periods(100.0, 0.2):
        lateness.append(late)
        if len(lateness) == 1:
            time.sleep(0.035)  # this period and three more
    assert min(lateness) >= 0
    assert len(lateness) <= 20 - 3


def test_each_statistic_of_the_loop_stands_beside_that_of_the_timer(monkeypatch):
    timer = Series(np.linspace(0.0, 100.0, 1001), 0, ["refused"])
    loop = Series(np.linspace(0.0, 200.0, 1001), 2, [])
    monkeypatch.setattr(real_time, "timer_lateness", lambda *_: timer)
    monkeypatch.setattr(real_time, "loop_answers", lambda *_: loop)
    monkeypatch.setattr(real_time, "find_spec", lambda _: None)
    monkeypatch.setattr(real_time, "RATES", (RATE,))
    *times, missed = real_time.real_time(BRIEF)[:5]
    assert [row.ratio for row in times] == pytest.approx([2.0] * 4)
    assert (missed.value, missed.reference_value, missed.ratio) == (2.0, 0.0, None)
    assert times[2].unit == "us, p99.9: the loop, 500 Hz, ordinary"
    assert {row.reference for row in times} == {"timer alone; refused"}
    units = [row.unit for row in real_time.real_time(BRIEF)]
    shared = "us, p99.9: the loop, driver and controller in one process, 500 Hz, priority 40"
    assert shared in units


@pytest.mark.parametrize("priority", [0, real_time.PRIORITY])
def test_the_parameters_of_the_loop_are_those_of_its_nodes(priority, tmp_path):
    path = tmp_path / "loop.yaml"
    path.write_text(yaml.safe_dump(real_time.parameters(RATE, priority, tmp_path / "times.npy")))
    configuration = load_configuration(path)
    for node in ("driver", "controller"):
        assert configuration.value(node, "control_rate") == RATE
        assert configuration.value(node, "real_time.priority") == priority
        assert configuration.value(node, "real_time.lock_memory") is (priority > 0)


def test_a_timer_and_bytes_are_measured_in_processes_of_their_own():
    measured = [real_time.timer_lateness(RATE, 0.2, 0)]
    if find_spec("cyclonedds") is not None:
        measured.append(real_time.byte_echoes(RATE, 0.2, 0))
    for series in measured:
        assert len(series.times) + series.missed == 100
        assert np.min(series.times) > 0.0
        assert series.refusals == []


@pytest.mark.parametrize("processes", real_time.LOOPS)
def test_the_loop_of_the_nodes_answers_the_drive(processes):
    series = real_time.loop_answers(RATE, 0.5, 0, processes)
    assert len(series.times) > 10  # of 100 or more, on a computer that has time
    assert np.min(series.times) > 0.0


def test_a_duration_that_is_none_is_refused(capsys):
    assert run_command(["bench", "real_time", "--duration", "nan"]) == 2
    assert capsys.readouterr().err == "error: --duration nan s: must be 1 to 86400\n"
