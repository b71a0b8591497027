"""Telemetry given to an estimator again: what comes out, and how it is counted."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from bdt_analysis.re_estimation.estimator_setup import estimator_setup
from bdt_analysis.re_estimation.re_estimation import re_estimate, telemetry_batches
from bdt_bags.reading.recording import load_recording
from bdt_msgs_py.topics import BACKLASH_ESTIMATE, TELEMETRY, TRUTH

SCRIPTED = '''
import math
from bdt_twin.estimator import Estimate, TelemetryRejectedError


class Scripted:
    """Says what the test wants to hear: truth and errors known in advance."""

    def __init__(self, model, sampling_rate):
        self.mass, self.rate, self.taken = model.structure.mass, sampling_rate, []

    def restart(self):
        pass

    def update(self, batch, *, newest_only=False):
        self.taken.append(len(batch))
        time, number = float(batch[-1, 0]), len(self.taken)
        gap = math.radians(30.0) * time / 2.0
        if number == 1:
            return Estimate(time, math.nan, math.inf, reason="no reversal")
        if number == 2:
            raise TelemetryRejectedError("the second batch")
        if number == 3:
            return None
        error = math.radians(3.0 if number % 2 else -1.0)
        self.last = Estimate(time, gap + error, math.radians(1.0))
        return self.last


class Repeating(Scripted):
    def update(self, batch, *, newest_only=False):
        if len(self.taken) < 5:
            return super().update(batch)
        return self.last._replace(uncertainty=1.0, reason="at rest")
'''

MY_FILE = """
from bdt_twin.estimator import Estimate

class MyEstimator:
    def restart(self):
        self.batches = 0

    def update(self, batch):
        self.batches += 1
        return Estimate(batch[-1, 0], 1.0 / (4 - self.batches))
"""


@pytest.fixture(scope="module")
def following(following_bag):
    return load_recording(following_bag)


@pytest.fixture(scope="module")
def small(small_loop, tmp_path_factory):
    return load_recording(small_loop.write(tmp_path_factory.mktemp("again") / "bag"))


@pytest.fixture
def scripted(tmp_path, monkeypatch):
    (tmp_path / "scripted_estimator.py").write_text(SCRIPTED)
    monkeypatch.syspath_prepend(tmp_path)
    yield "scripted_estimator:Scripted"
    sys.modules.pop("scripted_estimator", None)


def re_estimation(recording, **settings):
    given = {name.replace("__", "."): value for name, value in settings.items()}
    return re_estimate(recording, estimator_setup(recording, given))


def test_the_twin_s_estimator_says_the_same_again(following):
    found = re_estimation(following, estimator__kind="inverse_filter")
    assert found.summary.estimates > 100
    np.testing.assert_array_equal(found.estimates.gap, found.live.gap)
    np.testing.assert_allclose(found.estimates.time, following.estimates[:, 0], atol=1e-9)
    np.testing.assert_array_equal(found.live.gap, following.estimates[:, 1])
    assert found.summary.rms_error_deg == pytest.approx(found.summary.live.rms_error_deg, rel=1e-6)
    assert found.summary.coverage_95_percent is None, "this estimator states no uncertainty"
    assert found.summary.window_ms > 0
    assert found.summary.rejected == 0


def test_errors_are_those_at_the_time_for_which_the_gap_is_stated(following):
    """The gap grows by 30 degrees in 20 s, evenly."""
    found = re_estimation(following, estimator__kind="inverse_filter").estimates
    true_gap = np.deg2rad(30.0) * found.time / 20.0
    inside = found.time <= following.truth[-1, 0]
    np.testing.assert_allclose(found.error[inside], (found.gap - true_gap)[inside], atol=1e-12)


def test_another_estimator_beside_the_live_twin(following):
    """Fitted to signals without noise, the gap at a reversal is known; a mean over 2 s lags."""
    given = {"output_error__window": 10.0, "output_error__update_period": 2.0}
    summary = re_estimation(following, estimator__kind="output_error", **given).summary
    assert summary.estimator == "output_error"
    assert summary.settings == {"output_error.window": 10.0, "output_error.update_period": 2.0}
    assert summary.estimates + summary.kept == pytest.approx(10, abs=1)
    assert summary.worst_error_deg < 0.1 < summary.live.rms_error_deg
    assert summary.coverage_95_percent > 60.0


def test_a_wrong_model_makes_a_wrong_estimate(following):
    wrong = re_estimation(following, motor__back_emf_constant=0.12).summary
    assert wrong.estimator == "inverse_filter"
    assert wrong.rms_error_deg > 2.0 * wrong.live.rms_error_deg


def test_numbers_of_known_statements(small, scripted):
    """20 batches: the first three state nothing, then errors of -1 and 3 degrees in turn.

    The truth ends before the last sample: the last estimate has no error.
    """
    summary = re_estimation(small, estimator__kind=scripted).summary
    assert (summary.estimates, summary.kept, summary.rejected) == (17, 1, 1)
    assert summary.kept_reason == "no reversal"
    assert summary.rejected_reason == "the second batch"
    assert summary.rms_error_deg == pytest.approx(np.sqrt((8 * 1.0**2 + 8 * 3.0**2) / 16))
    assert summary.worst_error_deg == pytest.approx(3.0)
    assert summary.coverage_95_percent == 50.0


def test_an_estimate_that_is_repeated_counts_once(small, scripted):
    summary = re_estimation(
        small, estimator__kind=scripted.replace("Scripted", "Repeating")
    ).summary
    assert (summary.estimates, summary.kept) == (2, 16)


def test_batches_are_as_long_as_the_recorded_ones(small):
    assert [len(batch) for batch in telemetry_batches(small, 500.0)] == [50] * 20
    np.testing.assert_array_equal(np.concatenate(telemetry_batches(small, 500.0)), small.telemetry)


def test_a_bag_without_telemetry_comes_in_tenths_of_a_second(small_loop, tmp_path, scripted):
    recording = load_recording(small_loop.without(TELEMETRY).write(tmp_path / "bag"))
    lengths = [len(batch) for batch in telemetry_batches(recording, 50.0)]
    assert lengths == [5] * 20
    summary = re_estimation(recording, estimator__kind=scripted).summary
    assert (summary.sampling_rate_hz, summary.estimates) == (50.0, 17)


def test_a_hole_stays_within_its_batch(small):
    kept = np.delete(np.arange(1000), [0, *range(120, 130), *range(200, 250)])
    holed = replace(small, telemetry=small.telemetry[kept])
    assert [len(x) for x in telemetry_batches(holed, 500.0)] == [49, 50, 40, 50, *[50] * 15]
    summary = re_estimation(holed, estimator__kind="inverse_filter").summary
    assert summary.rejected == 2, "the batch with the hole, and the one after the lost batch"
    assert summary.rejected_reason.startswith("time step of 0.022000 s instead of 0.002000 s at")


def test_without_truth_and_without_a_twin(small_loop, tmp_path):
    bag = small_loop.without(TRUTH, BACKLASH_ESTIMATE).write(tmp_path / "bag")
    summary = re_estimation(load_recording(bag), estimator__kind="inverse_filter").summary
    assert summary.rms_error_deg is summary.worst_error_deg is summary.coverage_95_percent is None
    assert summary.live.estimates == 0


def test_the_bag_s_clock_may_count_from_1970(following):
    """The analysis subtracts whole seconds; stamps resolve a quarter of a microsecond."""
    shifted = following.telemetry.copy()
    shifted[:, 0] = (1.7e9 + shifted[:, 0]) - 1.7e9
    later = replace(following, telemetry=shifted, sample_times=shifted[:, 0], time_origin=1.7e9)
    summary = re_estimation(later, estimator__kind="output_error", output_error__window=5.0).summary
    assert summary.rejected == 0
    assert summary.estimates > 10


def analyzed_with_my_file(small_loop, tmp_path, text):
    """Return exit code, output and errors of ``bdt analyze`` where ``my_file.py`` lies."""
    (tmp_path / "my_file.py").write_text(text)
    bag = small_loop.write(tmp_path / "bag")
    command = [sys.executable, "-P", "-m", "bdt_bringup.cli", "analyze", str(bag)]
    done = subprocess.run(
        [*command, "--estimator", "my_file:MyEstimator"],
        cwd=tmp_path,
        check=False,
        capture_output=True,
        text=True,
    )
    return done.returncode, done.stdout, done.stderr


def test_the_shortest_class_in_the_current_folder_estimates_again(small_loop, tmp_path):
    text = MY_FILE.replace("1.0 / (4 - self.batches)", "0.1")
    code, out, err = analyzed_with_my_file(small_loop, tmp_path, text)
    assert code == 0, err
    assert "re-estimated (my_file:MyEstimator): 20 estimates" in out


def test_an_error_of_a_class_is_one_line_with_its_place(small_loop, tmp_path):
    code, _, err = analyzed_with_my_file(small_loop, tmp_path, MY_FILE)
    assert code == 2
    assert err == "error: my_file.py:10: ZeroDivisionError: float division by zero\n"
