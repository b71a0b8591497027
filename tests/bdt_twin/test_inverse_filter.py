"""The paper's estimator (eqs 12 to 14) against its equations word for word and against the truth.

Word for word but for one thing: omega_d != 0 of eq. 13 is read together with eq. 6, by which a
screw that moves turns the same way as the motor.
"""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bdt_plant import compilation
from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import PlantModel, Sampling
from bdt_plant.plant_simulator import PlantSimulator
from bdt_twin.angle_observer import AngleObserver
from bdt_twin.contact import compiled_sums
from bdt_twin.estimator import TelemetryRejectedError
from bdt_twin.iir_filters import compiled_filters, filter_motor_and_screw
from bdt_twin.inverse_filter import SAMPLES_AT_A_TIME, InverseFilterEstimator, InverseFilterSettings

RATE = 5000
ROUNDING = 0.1
"""Largest overestimate by eq. 13 [deg]: twice a rounding to 0.05 degrees; it is 0.05 on average."""
QUICK = InverseFilterSettings(window=0.4, update_period=0.02)


def settling(chosen):
    """Return the samples that an estimator skips after a restart."""
    return AngleObserver(PlantModel(), 1 / chosen.sampling_rate, chosen.delay).settling


def estimate(voltage, position, chosen=None, cuts=()):
    """Return the estimates from data given in batches that end at `cuts`."""
    estimator = InverseFilterEstimator(PlantModel(), chosen or InverseFilterSettings())
    bounds = [0, *sorted(cuts), len(voltage)]
    return [
        found
        for begin, end in pairwise(bounds)
        for found in estimator.estimates(voltage[begin:end], position[begin:end])
    ]


def errors_of(truth):
    """Return the errors [deg] of the estimates against the mean true gap of their windows."""
    window = round(InverseFilterSettings().window * RATE)
    errors = [
        found.gap - truth.gap[max(found.sample - window, 0) : found.sample].mean()
        for found in estimate(truth.voltage, truth.position)
    ]
    return np.rad2deg(errors)


def eq_13(theta_m, theta_d, chosen, newest):
    """Return (gap [rad], forward, backward) of the window up to sample `newest`, word for word."""
    sample_time, scale = 1 / chosen.sampling_rate, chosen.rounding / 2
    oldest = max(
        settling(chosen),
        newest - round(chosen.window * chosen.sampling_rate),
    )
    plus, minus = [], []
    for sample in range(oldest + 1, newest + 1):
        omega_m = (theta_m[sample] - theta_m[sample - 1]) / sample_time
        omega_d = (theta_d[sample] - theta_d[sample - 1]) / sample_time
        difference = math.degrees(theta_m[sample] - theta_d[sample])
        if omega_d > chosen.velocity_threshold and omega_m > 0:
            plus.append(scale * math.ceil(difference / scale))
        if omega_d < -chosen.velocity_threshold and omega_m < 0:
            minus.append(scale * math.floor(difference / scale))
    if not plus or not minus:
        return None, len(plus), len(minus)
    mean = sum(plus) / len(plus) - sum(minus) / len(minus)
    return math.radians(mean), len(plus), len(minus)


@pytest.mark.parametrize(
    "chosen",
    [
        QUICK,
        InverseFilterSettings(window=0.2, update_period=0.1, rounding=1.0, delay=1),
        InverseFilterSettings(window=0.1, update_period=0.1, velocity_threshold=5.0, delay=9),
    ],
    ids=["quick", "coarse", "fast screw only"],
)
def test_every_estimate_is_that_of_eq_13_word_for_word(constant_gap, chosen):
    truth = constant_gap(10.0)
    voltage, position = truth.voltage[: 3 * RATE], truth.position[: 3 * RATE]
    angles = AngleObserver(PlantModel(), 1 / RATE, chosen.delay).update(voltage, position)
    theta_m, theta_d = (array.tolist() for array in angles)
    estimates = estimate(voltage, position, chosen)
    assert len(estimates) >= 5
    for found in estimates:
        gap, forward, backward = eq_13(theta_m, theta_d, chosen, found.sample)
        assert found.gap == pytest.approx(gap, abs=1e-12)
        assert (found.forward, found.backward) == (forward, backward)


def test_estimates_come_at_the_ends_of_the_update_periods(constant_gap):
    truth = constant_gap(10.0)
    estimates = estimate(truth.voltage, truth.position, QUICK)
    begin = settling(QUICK)
    assert {(found.sample - begin) % 100 for found in estimates} == {0}
    assert estimates[-1].sample < truth.voltage.size


def test_no_update_period_with_contact_and_both_directions_is_left_out(constant_gap):
    truth = constant_gap(10.0)
    voltage, position = truth.voltage[: 3 * RATE], truth.position[: 3 * RATE]
    angles = AngleObserver(PlantModel(), 1 / RATE, QUICK.delay).update(voltage, position)
    theta_m, theta_d = (array.tolist() for array in angles)
    one_period = InverseFilterSettings(window=0.02, update_period=0.02)
    begin = settling(QUICK)
    expected = []
    for newest in range(begin + 100, 3 * RATE, 100):
        _, *contacts = eq_13(theta_m, theta_d, one_period, newest)
        gap, *_ = eq_13(theta_m, theta_d, QUICK, newest)
        if any(contacts) and gap is not None:
            expected.append(newest)
    assert [found.sample for found in estimate(voltage, position, QUICK)] == expected


@pytest.mark.parametrize("degrees", [0.0, 1.0, 3.0, 10.0, 20.0, 30.0])
def test_a_constant_gap_is_overestimated_by_the_rounding_and_no_more(constant_gap, degrees):
    errors = errors_of(constant_gap(degrees))
    assert len(errors) > 40
    assert errors.min() > 0.0
    assert errors.max() < ROUNDING


@pytest.mark.parametrize(("first", "last"), [(0.0, 5.0), (25.0, 30.0), (12.0, 10.0)])
def test_a_changing_gap_is_found_like_a_constant_one_of_its_mean_over_the_window(
    growing_gap, first, last
):
    errors = errors_of(growing_gap(first, last, 20.0))
    assert len(errors) > 100
    assert errors.min() > 0.0
    assert errors.max() < ROUNDING


@pytest.mark.parametrize("shift", [-1, 1])
def test_one_sample_of_misalignment_does_not_pass_for_rounding(constant_gap, shift):
    """The tolerance above is sharp enough to see a delay that is wrong by one: 1.3 degrees."""
    truth = constant_gap(10.0)
    errors = errors_of(
        truth._replace(position=np.roll(truth.position, shift)[1:-1], voltage=truth.voltage[1:-1])
    )
    assert np.abs(errors).min() > 10 * ROUNDING


@pytest.fixture(scope="module")
def recording():
    """Voltage and position of one second with several reversals."""
    gap = GapProfile(kind="constant", initial=0.1)
    plant = PlantSimulator(PlantModel(), gap, Sampling(RATE, 500.0))
    rows = [plant.advance(8 * math.cos(0.08 * command)) for command in range(500)]
    _, voltage, position = np.concatenate(rows).T.copy()
    return voltage, position


@pytest.fixture(scope="module")
def whole(recording):
    """Estimates from all data at once."""
    estimates = estimate(*recording, QUICK)
    assert len(estimates) > 20
    return estimates


@settings(max_examples=40)
@given(data=st.data())
def test_any_split_into_batches_gives_the_same_estimates_exactly(recording, whole, data):
    cuts = data.draw(st.lists(st.integers(0, recording[0].size), max_size=40))
    assert estimate(*recording, QUICK, cuts) == whole


@pytest.mark.parametrize("size", [1, 7, 100, 101])
def test_batches_of_equal_size_give_the_same_estimates_exactly(recording, whole, size):
    cuts = range(size, recording[0].size, size)
    assert estimate(*recording, QUICK, cuts) == whole


def test_data_longer_than_a_stretch_gives_the_same_estimates_exactly(constant_gap):
    truth = constant_gap(10.0)
    assert truth.voltage.size > 2 * SAMPLES_AT_A_TIME
    cuts = [
        100,
        SAMPLES_AT_A_TIME - 1,
        SAMPLES_AT_A_TIME,
        SAMPLES_AT_A_TIME + 1,
        2 * SAMPLES_AT_A_TIME + 7,
    ]
    expected = estimate(truth.voltage, truth.position, QUICK)
    assert estimate(truth.voltage, truth.position, QUICK, cuts) == expected
    by_the_batch = range(500, truth.voltage.size, 500)
    assert estimate(truth.voltage, truth.position, QUICK, by_the_batch) == expected


def test_empty_batches_change_nothing(recording, whole):
    half = recording[0].size // 2
    cuts = [0, 0, half, half, half, recording[0].size]
    assert estimate(*recording, QUICK, cuts) == whole


def test_turning_all_signs_swaps_the_directions_and_keeps_the_gap(recording, whole):
    turned = estimate(*(-column for column in recording), QUICK)
    expected = [found._replace(forward=found.backward, backward=found.forward) for found in whole]
    assert turned == expected


def test_a_platform_that_rests_elsewhere_has_the_same_gap(constant_gap):
    truth = constant_gap(10.0)
    errors = errors_of(truth._replace(position=truth.position + 0.1234567))
    assert errors.min() > 0.0
    assert errors.max() < ROUNDING


def test_without_motion_there_is_no_estimate():
    assert estimate(np.zeros(3 * RATE), np.zeros(3 * RATE)) == []
    assert estimate(np.zeros(3 * RATE), np.full(3 * RATE, 5e-3)) == []


def test_without_a_reversal_there_is_no_estimate():
    voltage = np.full(2 * RATE, 6.0)
    turns = 60.0 * np.arange(2 * RATE) / RATE
    assert estimate(voltage, turns * 1e-3 / (2 * math.pi)) == []


def test_once_the_screw_is_at_rest_there_are_no_more_estimates(constant_gap):
    truth = constant_gap(10.0)
    rest = np.full(3 * RATE, truth.position[-1])
    voltage = np.append(truth.voltage, np.zeros(3 * RATE))
    estimates = estimate(voltage, np.append(truth.position, rest))
    assert estimates[-1].sample < truth.voltage.size + 1.2 * settling(QUICK)


def test_an_old_reversal_leaves_with_the_window(constant_gap):
    truth = constant_gap(10.0)
    estimates = estimate(truth.voltage, truth.position, QUICK)
    assert max(found.forward + found.backward for found in estimates) <= 0.4 * RATE


def test_a_restart_forgets_everything(recording, whole):
    estimator = InverseFilterEstimator(PlantModel(), QUICK)
    estimator.estimates(*(column[:3210] for column in recording))
    estimator.restart()
    assert estimator.estimates(*recording) == whole


def test_a_restart_while_the_structure_swings_finds_the_gap_again(constant_gap):
    truth = constant_gap(10.0)
    begin = 2 * RATE + 700  # in the middle of the second step
    errors = errors_of(truth._make(column[begin:] for column in truth))
    assert len(errors) > 20
    assert errors.min() > 0.0
    assert errors.max() < ROUNDING


@pytest.mark.parametrize(
    ("fault", "text"),
    [
        ({"window": 0.25}, r"window = 0\.25 s: must be a multiple of update_period \(0\.1 s\)"),
        ({"window": 0.05}, r"window = 0\.05 s: must be a multiple of update_period \(0\.1 s\)"),
        (
            {"update_period": 0.01, "sampling_rate": 250.0},
            r"update_period = 0\.01 s: must be a whole number of samples at 250 Hz",
        ),
        ({"sampling_rate": 0.0}, r"sampling_rate = 0\.0 Hz: must be 1 to 100000 Hz"),
        ({"velocity_threshold": -1.0}, r"velocity_threshold = -1\.0 rad/s: must be 0 to 1e\+06"),
        ({"delay": 0}, r"delay = 0 samples: must be 1 to 1000 samples"),
        ({"delay": 2.0}, r"delay = 2\.0: must be an integer, 1 to 1000 samples"),
        ({"delay": True}, r"delay = True: must be an integer, 1 to 1000 samples"),
        ({"rounding": 0.0}, r"rounding = 0\.0 deg: must be 1e-06 to 90 deg"),
        ({"window": float("nan")}, r"window = nan s: must be 0\.001 to 10000 s"),
        ({"update_period": "0.1"}, r"update_period = '0\.1': must be a number, 0\.001 to 10000 s"),
    ],
)
def test_a_fault_is_named_with_its_value_and_what_is_allowed(fault, text):
    with pytest.raises(ValueError, match=r"^InverseFilterSettings\." + text):
        InverseFilterSettings(**fault)


def test_the_defaults_are_those_of_the_paper():
    chosen = InverseFilterSettings()
    assert chosen.sampling_rate == 5000.0
    assert chosen.velocity_threshold == 0.1
    assert chosen.delay == 2
    assert chosen.rounding == 0.1


@pytest.fixture
def without_numba(monkeypatch):
    monkeypatch.setattr(compilation, "find_spec", lambda _: None)
    compiled = (compiled_sums, compiled_filters)
    for loop in compiled:
        loop.cache_clear()
    yield
    for loop in compiled:
        loop.cache_clear()


@pytest.mark.usefixtures("without_numba")
def test_without_numba_the_estimates_are_the_same_exactly(recording, whole):
    assert compiled_filters() is filter_motor_and_screw
    assert estimate(*recording, QUICK) == whole


# As an Estimator ------------------------------------------------------------------------------


def rows_from(telemetry, start):
    times = start + np.arange(len(telemetry[0])) / RATE
    return np.column_stack([times, *telemetry])


def test_a_batch_gives_the_newest_of_its_estimates_with_its_time(recording, whole):
    estimator = InverseFilterEstimator(PlantModel(), QUICK)
    estimate = estimator.update(rows_from(recording, 7.0))
    assert estimate.gap == whole[-1].gap
    assert estimate.time == pytest.approx(7.0 + whole[-1].sample / RATE, abs=1e-12)
    assert np.isnan(estimate.uncertainty)
    assert estimate.reason == ""


def test_a_hole_is_rejected_and_the_next_batch_begins_anew(recording, whole):
    estimator = InverseFilterEstimator(PlantModel(), QUICK)
    rows = rows_from(recording, 0.0)
    estimator.update(rows[:1000])
    with pytest.raises(TelemetryRejectedError, match="time step of"):
        estimator.update(rows_from(recording, 30.0))
    estimate = estimator.update(rows_from(recording, 50.0))
    assert estimate.gap == whole[-1].gap
    assert estimate.time == pytest.approx(50.0 + whole[-1].sample / RATE, abs=1e-12)


def test_batches_without_an_estimate_that_is_due_give_none(recording):
    estimator = InverseFilterEstimator(PlantModel(), QUICK)
    assert estimator.update(rows_from(recording, 0.0)[:5]) is None
