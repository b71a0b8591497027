"""A loop is judged by the true position, as far as somebody knows it."""

import numpy as np
import pytest

from bdt_analysis.analyze import analyze
from bdt_analysis.metrics.performance_output import performance_output
from bdt_bags.run_signals import RunSignals
from bdt_msgs_py.topics import TRUTH
from bdt_plant.sensor import SensorParameters

TIMES = np.arange(1000) / 1000
POSITION = np.sin(TIMES)


def run_with(noise, truth=slice(None, None, 10)):
    """Return a run whose truth holds every tenth sample, or part of these."""
    telemetry = np.column_stack([TIMES, np.ones(1000), POSITION + noise])
    rows = np.zeros((1000, 7))
    rows[:, 0], rows[:, 6] = TIMES, POSITION
    nothing = np.empty((0, 2))
    return RunSignals(
        telemetry=telemetry,
        truth=None if truth is None else rows[truth],
        reference=nothing,
        estimates=nothing,
        dead_zones=nothing,
        pitch=1.0,
    )


def test_noisy_telemetry_gives_way_to_the_truth_at_its_rate():
    noise = np.random.default_rng(1).normal(size=1000)
    rows, sample_time = performance_output(run_with(noise))
    np.testing.assert_array_equal(rows, np.column_stack([TIMES, np.ones(1000), POSITION])[::10])
    assert sample_time == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("noise", "truth"),
    [
        (0.0, slice(None, None, 10)),  # the telemetry is true
        (1.0, None),  # nobody knows the truth
        (1.0, slice(0, 500, 10)),  # it ends early
        (1.0, slice(200, None, 10)),  # it begins late
        (1.0, np.delete(np.arange(0, 1000, 10), 50)),  # it has a hole
        (1.0, np.arange(1)),
    ],
)
def test_otherwise_the_telemetry_is_taken_as_it_is(noise, truth):
    run = run_with(noise, truth)
    rows, sample_time = performance_output(run)
    assert rows is run.telemetry
    assert sample_time == run.sample_time


def test_noise_of_the_sensor_is_no_residual_of_the_loop(loop_messages, tmp_path):
    """White noise of 5 um rms spans 40 um; the loop reacts to it with far less."""
    messages = loop_messages(
        duration=16.0,
        step_time=8.0,
        final_gap=0.0,
        dead_zone=0.0,
        sampling_rate=1000.0,
        sensor=SensorParameters(noise=5e-6),
    )
    known = analyze(messages.write(tmp_path / "known"))
    unknown = analyze(messages.without(TRUTH).write(tmp_path / "unknown"))
    for true, measured in zip(known.steps, unknown.steps, strict=True):
        assert measured.residual_peak_to_peak_m > 3e-5
        assert true.residual_peak_to_peak_m < 0.5 * measured.residual_peak_to_peak_m
        assert true.bias_m == pytest.approx(measured.bias_m, abs=1e-6)
        assert true.limit_cycle is measured.limit_cycle is False
