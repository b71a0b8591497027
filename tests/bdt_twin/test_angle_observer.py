"""The angles on both sides of the backlash (eqs 10 and 11) against eqs 2 and 3 and the truth."""

import math
from itertools import pairwise

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from bdt_plant.plant import PlantModel
from bdt_plant.structure import StructureParameters
from bdt_twin.angle_observer import AngleObserver, motor_filter, structure_filter

SAMPLE_TIME = 2e-4
PITCH = 1e-3 / (2 * math.pi)
# Table 1 in the printed coefficients of eqs 2 and 3.
EQ_2 = control.tf([0.8], [5e-6 * 1e-3, 5e-6 * 12, 0.1 * 0.8, 0])
M, K, C = 5.2, 1e4, 36.9
EQ_3 = control.tf([C**2, 2 * C * K, K**2], [M**2, 3 * C * M, C**2 + 3 * K * M, 2 * C * K, K**2])

INVERSE_SETTLING = 500
"""Samples after which the inverse filter has forgotten its start: 0.948 ** 500 is 3e-12."""


def observe(voltage, position, delay=2, cuts=()):
    """Return the angles of the data, given to an observer in batches that end at `cuts`."""
    observer = AngleObserver(PlantModel(), SAMPLE_TIME, delay)
    bounds = [0, *sorted(cuts), len(voltage)]
    batches = [
        observer.update(voltage[begin:end], position[begin:end]) for begin, end in pairwise(bounds)
    ]
    return tuple(np.concatenate(angles) for angles in zip(*batches, strict=True))


def noise(count, seed=6):
    return np.random.default_rng(seed).uniform(-1, 1, count)


def test_the_zeros_of_the_structure_filter_lie_where_the_paper_needs_them():
    """Minimum phase up to a zero at the origin, so that the inverse is stable."""
    numerator, _ = structure_filter(PlantModel(), SAMPLE_TIME)
    zeros = np.sort(np.roots(numerator))
    assert zeros.tolist() == pytest.approx([0.946, 0.948], abs=5e-4)


def test_the_pole_excess_of_the_structure_filter_is_one():
    numerator, denominator = structure_filter(PlantModel(), SAMPLE_TIME)
    assert denominator[0] == 1.0
    assert numerator[0] == 0.0
    assert numerator[1] > 1e-7


def test_the_structure_filter_has_unit_gain_at_rest():
    numerator, denominator = structure_filter(PlantModel(), SAMPLE_TIME)
    assert numerator.sum() / denominator.sum() == pytest.approx(1.0, abs=1e-6)


def test_the_poles_of_the_structure_filter_are_those_of_eq_3():
    _, denominator = structure_filter(PlantModel(), SAMPLE_TIME)
    expected = np.poly(np.exp(EQ_3.poles() * SAMPLE_TIME)).real
    # Four poles within 0.03 of one: their polynomial is what is well conditioned.
    np.testing.assert_allclose(denominator, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("sample_time", [2e-4, 1e-3, 2e-3])
def test_the_impulse_response_is_that_of_eq_3_times_the_sample_time(sample_time):
    numerator, denominator = structure_filter(PlantModel(), sample_time)
    times = np.arange(1000) * sample_time
    expected = sample_time * control.impulse_response(EQ_3, times).outputs
    impulse = np.zeros(times.size)
    impulse[0] = 1.0
    found = lfilter(numerator, denominator, impulse)
    # Four poles next to one amplify rounding of the coefficients, as in the gain at rest.
    assert np.abs(found - expected).max() <= 1e-6 * np.abs(expected).max()


def test_the_motor_filter_is_eq_2_behind_a_zero_order_hold():
    numerator, denominator = motor_filter(PlantModel(), SAMPLE_TIME)
    voltage = 12 * noise(1000)
    held = control.sample_system(control.ss(EQ_2), SAMPLE_TIME, "zoh")
    expected = control.forced_response(held, np.arange(1000) * SAMPLE_TIME, voltage).outputs
    np.testing.assert_allclose(lfilter(numerator, denominator, voltage), expected, atol=1e-11)


def test_the_poles_of_the_motor_filter_are_those_of_eq_2():
    _, denominator = motor_filter(PlantModel(), SAMPLE_TIME)
    expected = np.poly(np.exp(EQ_2.poles() * SAMPLE_TIME)).real
    np.testing.assert_allclose(denominator, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("delay", [1, 2, 7])
def test_the_observer_inverts_the_structure_filter(delay):
    d = 1e-3 * noise(2000)
    d[:5] = 0.0  # at rest before the first sample
    position = lfilter(*structure_filter(PlantModel(), SAMPLE_TIME), d)
    _, theta_d = observe(np.zeros(2000), position, delay)
    # An inverse that is exact but for rounding, amplified by two derivatives at 5000 Hz.
    np.testing.assert_allclose(theta_d[delay:], d[:-delay] / PITCH, rtol=0, atol=1e-6)


@pytest.mark.parametrize("delay", [1, 2, 7])
def test_the_angle_of_the_motor_is_the_true_one_delayed(constant_gap, delay):
    truth = constant_gap(10.0)
    theta_m, _ = observe(truth.voltage, truth.position, delay)
    assert not theta_m[:delay].any()
    # Tens of radians over 40 000 samples: rounding of a recursion with a pole at one.
    assert np.abs(theta_m[delay:] - truth.theta_m[:-delay]).max() < 1e-9


def test_the_angle_of_the_screw_is_close_to_the_true_one_delayed(constant_gap):
    truth = constant_gap(10.0)
    _, theta_d = observe(truth.voltage, truth.position)
    error = np.rad2deg(theta_d[2:] - truth.theta_d[:-2])[INVERSE_SETTLING:]
    # The screw turns 4500 degrees. Impulse invariance is not exact for a moving screw, worst
    # where it takes off or stops: 0.12 degrees there, 0.003 on average.
    assert np.abs(error).max() < 0.2
    assert np.sqrt(np.mean(error**2)) < 0.005


def test_delays_only_delay(constant_gap):
    truth = constant_gap(10.0)
    short, long = (observe(truth.voltage[:5000], truth.position[:5000], n) for n in (1, 6))
    for early, late in zip(short, long, strict=True):
        assert (early[:-5] == late[5:]).all()


@settings(max_examples=60)
@given(data=st.data(), count=st.integers(0, 300), delay=st.integers(1, 12))
def test_any_split_into_batches_gives_the_same_angles_bit_for_bit(data, count, delay):
    """Equal cuts make empty batches, neighboring ones make batches of a single sample."""
    cuts = data.draw(st.lists(st.integers(0, count), max_size=30))
    voltage, position = 12 * noise(count), 1e-3 * noise(count, 7)
    whole = observe(voltage, position, delay)
    for one, other in zip(whole, observe(voltage, position, delay, cuts), strict=True):
        assert one.tobytes() == other.tobytes()


def test_empty_batches_change_nothing():
    voltage, position = 12 * noise(200), 1e-3 * noise(200, 7)
    whole = observe(voltage, position)
    cuts = [0, 0, *range(10, 200, 10), *range(10, 200, 10), 200]
    for one, other in zip(whole, observe(voltage, position, cuts=cuts), strict=True):
        assert one.tobytes() == other.tobytes()


def test_single_samples_give_the_same_angles_bit_for_bit():
    voltage, position = 12 * noise(200), 1e-3 * noise(200, 7)
    whole = observe(voltage, position)
    for one, other in zip(whole, observe(voltage, position, cuts=range(1, 200)), strict=True):
        assert one.tobytes() == other.tobytes()


def test_turning_all_signs_turns_the_angles_exactly(constant_gap):
    truth = constant_gap(10.0)
    forward = observe(truth.voltage, truth.position)
    backward = observe(-truth.voltage, -truth.position)
    for one, other in zip(forward, backward, strict=True):
        assert (one == -other).all()


def test_a_platform_that_rests_elsewhere_shifts_the_screw_and_nothing_else(constant_gap):
    truth = constant_gap(10.0)
    here = observe(truth.voltage, truth.position)
    there = observe(truth.voltage, truth.position + 0.1)
    assert (here[0] == there[0]).all()
    # Rounding of a position of 0.1 m to 1.4e-17 m, amplified by two derivatives at 5000 Hz.
    np.testing.assert_allclose(there[1] - here[1], 0.1 / PITCH, rtol=0, atol=1e-5)


def test_a_platform_at_rest_means_a_screw_at_rest_from_the_first_sample_on():
    _, theta_d = observe(np.zeros(100), np.full(100, 5e-3))
    np.testing.assert_allclose(theta_d, 5e-3 / PITCH, rtol=1e-14)


def test_a_restart_forgets_all_samples():
    observer = AngleObserver(PlantModel(), SAMPLE_TIME, 3)
    voltage, position = 12 * noise(50), 5e-3 + 1e-3 * noise(50, 7)
    first = observer.update(voltage, position)
    observer.restart()
    for one, other in zip(first, observer.update(voltage, position), strict=True):
        assert one.tobytes() == other.tobytes()


@pytest.mark.parametrize("delay", [0, -1])
def test_a_delay_below_the_pole_excess_is_refused(delay):
    with pytest.raises(ValueError, match=rf"delay = {delay} samples: must be 1 or more"):
        AngleObserver(PlantModel(), SAMPLE_TIME, delay)


@pytest.mark.parametrize("damping", [0.0, 0.3, 0.5])
def test_a_structure_too_lightly_damped_for_a_stable_inverse_is_refused_by_name(damping):
    model = PlantModel(structure=StructureParameters(damping=damping))
    with pytest.raises(ValueError, match=r"structure\.damping = .* must be larger"):
        AngleObserver(model, 1 / 5000, 2)


def test_the_settling_time_follows_the_slowest_pole_of_the_filters():
    stiff = AngleObserver(PlantModel(), 1 / 5000, 2).settling
    # The zeros of G2 lie near exp(-k / (c f)); 1e-9 is reached after c f ln(1e9) / k samples.
    assert stiff == pytest.approx(36.9 * 5000 * np.log(1e9) / 1e4, rel=0.05)
    damped = PlantModel(structure=StructureParameters(damping=369.0))
    assert AngleObserver(damped, 1 / 5000, 2).settling > 5 * stiff
