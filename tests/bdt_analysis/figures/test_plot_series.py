"""The curves of the plots: what is drawn is what was recorded."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from bdt_analysis.figures.plot_series import panels, run_series
from bdt_analysis.metrics.gap_estimates import GapEstimates
from bdt_analysis.metrics.reference_steps import find_steps
from bdt_analysis.re_estimation.re_estimation import ReEstimation
from bdt_bags.run_signals import RunSignals

PITCH = 1e-3 / (2 * np.pi)


@pytest.fixture
def run() -> RunSignals:
    """Ten seconds at 1 kHz: q3 rings around a reference that steps at 5 s."""
    time = np.arange(10_000) * 1e-3
    reference = np.where(time < 5, 5e-3, 1e-3)
    q3 = reference + 1e-5 * np.sin(2 * np.pi * 3 * time)
    q3[7777] = 9e-3  # a single sample that a picture must not lose
    gap = np.full(time.size, 0.1)
    zero = np.zeros(time.size)
    return RunSignals(
        telemetry=np.stack([time, np.cos(time), q3], axis=1),
        truth=np.stack([time, zero, zero, gap, zero, zero, q3], axis=1),
        reference=np.array([[0.0, 5e-3], [5.0, 1e-3]]),
        estimates=np.array([[1.0, 0.08], [4.0, 0.11]]),
        dead_zones=np.array([[0.0, 0.0], [2.0, 0.08 * PITCH]]),
        pitch=PITCH,
    )


def steps_of(run):
    return find_steps(run.reference, run.telemetry, run.sample_time)


def curves(run, most_points=7_000):
    return {c.name: c for c in run_series(run, steps_of(run), most_points) if not c.quiet}


def test_units_are_those_of_the_panels(run):
    found = curves(run, 100_000)
    np.testing.assert_allclose(found["position q3"].value, 1e3 * run.telemetry[:, 2])
    np.testing.assert_allclose(found["voltage u"].value, np.cos(run.telemetry[:, 0]))
    np.testing.assert_allclose(found["true gap"].value, np.rad2deg(0.1))
    assert found["estimated gap"].value.tolist() == pytest.approx(np.rad2deg([0.08, 0.11, 0.11]))
    assert found["dead zone ε/p"].value[-1] == pytest.approx(np.rad2deg(0.08))
    assert found["dead zone ±ε"].value.max() == pytest.approx(1e6 * 0.08 * PITCH)
    assert found["reference r"].value.tolist() == [5, 1, 1]


def test_the_error_is_that_against_the_reference_of_its_time(run):
    error = curves(run, 100_000)["q3 − r"]  # noqa: RUF001
    expected = 10 * np.sin(2 * np.pi * 3 * run.telemetry[:, 0])
    expected[7777] = 8000
    np.testing.assert_allclose(error.value, expected, atol=1e-6)


def test_decimation_keeps_real_samples_and_every_extreme(run):
    position = curves(run)["position q3"]
    recorded = dict(zip(run.telemetry[:, 0], 1e3 * run.telemetry[:, 2], strict=True))
    assert sum(curve.time.size for curve in curves(run, 20_000).values()) <= 20_000
    assert position.time.size < 10_000
    assert position.samples == 10_000
    assert position.bin_width == pytest.approx(9.999 / 1875)
    assert all(
        recorded[t] == v for t, v in zip(position.time.tolist(), position.value, strict=True)
    )
    assert position.value.max() == pytest.approx(9.0)
    assert curves(run)["q3 − r"].value.max() == pytest.approx(8000)  # noqa: RUF001


def test_few_samples_are_held_whole(run):
    position = curves(run, 100_000)["position q3"]
    assert position.time.size == position.samples == 10_000
    assert position.bin_width is None


def test_the_true_position_is_drawn_where_it_differs(run):
    assert "true q3" not in curves(run)
    noisy = run.telemetry + np.array([0.0, 0.0, 1e-6])
    found = curves(replace(run, telemetry=noisy), 100_000)
    difference = found["position q3"].value - found["true q3"].value
    np.testing.assert_allclose(difference, 1e-3, atol=1e-9)


def test_a_bag_without_truth_estimates_and_dead_zones(run):
    empty = np.empty((0, 2))
    bare = replace(run, truth=None, estimates=empty, dead_zones=empty)
    assert set(curves(bare)) == {"position q3", "q3 − r", "voltage u", "reference r"}  # noqa: RUF001


def test_before_the_first_reference_there_is_no_error(run):
    late = replace(run, reference=np.array([[5.0, 1e-3]]))
    error = curves(late)["q3 − r"]  # noqa: RUF001
    assert error.time.min() == pytest.approx(5.0)


def test_a_hole_in_the_telemetry_interrupts_the_line(run):
    holed = replace(run, telemetry=np.delete(run.telemetry, slice(4000, 4500), axis=0))
    position = curves(holed)["position q3"]
    (hole,) = np.flatnonzero(np.isnan(position.value))
    assert position.time[hole] == pytest.approx(4.5)


def test_single_missing_samples_leave_the_line_whole(run):
    kept = np.arange(len(run.telemetry)) % 10 != 5
    position = curves(replace(run, telemetry=run.telemetry[kept]))["position q3"]
    assert np.isfinite(position.value).all()


def test_the_uncertainty_is_a_band_around_the_estimate_in_force(run):
    known = np.array([[0.5, 0.1], [1.0, np.inf], [1.5, 0.01], [4.0, 0.02]])
    uncertain = replace(run, uncertainties=known)
    lower, upper = [x for x in run_series(uncertain, steps_of(run)) if "±" in x.name][-2:]
    assert lower.panel == upper.panel == "gap"
    assert upper.fill
    assert lower.time[:2].tolist() == upper.time[:2].tolist() == [1.5, 4.0]
    np.testing.assert_allclose(np.deg2rad(lower.value[:2]), [0.08 - 0.02, 0.11 - 0.04])
    np.testing.assert_allclose(np.deg2rad(upper.value[:2]), [0.08 + 0.02, 0.11 + 0.04])


def test_a_re_estimate_has_a_curve_and_a_band_of_its_own(run):
    time, none = np.array([2.0, 6.0]), np.full(2, np.nan)
    stated = GapEstimates(time, np.array([0.09, 0.1]), np.array([0.01, 0.02]), none)
    summary = SimpleNamespace(estimator="output_error")
    curves = run_series(run, steps_of(run), re_estimation=ReEstimation(stated, stated, summary))
    assert [curve.name for curve in run_series(run, steps_of(run))] == [
        curve.name for curve in curves[:-3]
    ]
    lower, upper, line = curves[-3:]
    assert line.name == "re-estimated (output_error)"
    assert {curve.panel for curve in curves[-3:]} == {"gap"}
    (live,) = [curve for curve in curves if curve.name == "estimated gap"]
    assert {curve.color for curve in curves[-3:]} == {line.color} != {live.color}
    assert line.time.tolist() == pytest.approx([2.0, 6.0, 9.999])
    np.testing.assert_allclose(np.deg2rad(line.value), [0.09, 0.1, 0.1])
    np.testing.assert_allclose(np.deg2rad(upper.value), [0.11, 0.14, 0.14])
    np.testing.assert_allclose(np.deg2rad(lower.value), [0.07, 0.06, 0.06])
    unsure = replace(stated, uncertainty=none)
    curves = run_series(run, steps_of(run), re_estimation=ReEstimation(unsure, stated, summary))
    assert [curve.name for curve in curves if "re-est" in curve.name] == [line.name]


def test_the_error_begins_at_the_scale_of_what_is_left(run):
    quiet = replace(run, telemetry=run.telemetry.copy())
    quiet.telemetry[7777, 2] = 1e-3
    error = next(panel for panel in panels(quiet, steps_of(quiet)) if panel.key == "error")
    largest = max(10.0, 1e6 * 0.08 * PITCH)
    assert error.range == pytest.approx((-1.2 * largest, 1.2 * largest), rel=1e-3)
