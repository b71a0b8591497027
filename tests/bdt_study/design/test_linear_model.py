"""Linear models against the fractions that the paper prints, and against the cores that run."""

import math

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bdt_controller.control_law import INITIAL_CONTROL, control_step, discretize_control
from bdt_controller.notch import NO_NOTCH, NotchFilter
from bdt_controller.pid import PidGains
from bdt_plant.lead_screw import LeadScrewParameters
from bdt_plant.motor import MotorParameters
from bdt_plant.plant import AT_REST, PlantModel, discretize_plant, plant_step
from bdt_plant.structure import StructureParameters
from bdt_study.design.linear_model import (
    closed_loop,
    closed_loop_poles,
    frequency_response,
    is_stable,
    loop_transfer,
    motor_model,
    notch_model,
    pid_model,
    plant_model,
    sampled_loop_transfer,
    structure_model,
)

FREQUENCY = np.geomspace(0.1, 2e4, 300)
S = 1j * FREQUENCY
MODEL = PlantModel()
GAINS = PidGains(3080.0, 30800.0, -308.4, 0.074)

factors = st.floats(0.2, 5.0)


def eq_2(s, motor):
    j, ind, r = motor.inertia, motor.inductance, motor.resistance
    k_t, k_b = motor.torque_constant, motor.back_emf_constant
    return k_t / (j * ind * s**2 + j * r * s + k_b * k_t) / s


def eq_3(s, structure):
    m, k, c = structure.mass, structure.stiffness, structure.damping
    top = c**2 * s**2 + 2 * c * k * s + k**2
    rest = 3 * c * m * s**3 + (c**2 + 3 * k * m) * s**2 + 2 * c * k * s + k**2
    return top / (m**2 * s**4 + rest)


def eq_4(s, gains):
    derivative = gains.derivative * s / (gains.filter_time * s + 1)
    return gains.proportional + gains.integral / s + derivative


@settings(max_examples=20, deadline=None)
@given(factors, factors, factors, factors, factors)
def test_the_motor_is_eq_2(j, ind, r, k_t, k_b):
    motor = MotorParameters(5e-6 * j, 1e-3 * ind, 12.0 * r, 0.8 * k_t, 0.1 * k_b)
    response = frequency_response(motor_model(motor), FREQUENCY)
    np.testing.assert_allclose(response, eq_2(S, motor), rtol=1e-9)


@settings(max_examples=20, deadline=None)
@given(factors, factors, factors)
def test_the_structure_is_eq_3(m, k, c):
    structure = StructureParameters(5.2 * m, 1e4 * k, 36.9 * c)
    # Above the modes q3 hardly moves: what is left there is rounding of the shifted states.
    response = frequency_response(structure_model(structure), FREQUENCY)
    np.testing.assert_allclose(response, eq_3(S, structure), rtol=1e-9, atol=1e-14)


@settings(max_examples=20, deadline=None)
@given(st.floats(-1e4, 1e4), st.floats(-1e5, 1e5), st.floats(-1e3, 1e3), st.floats(1e-3, 10))
def test_the_controller_is_eq_4(k_p, k_i, k_d, t_f):
    gains = PidGains(k_p, k_i, k_d, t_f)
    size = abs(k_p) + abs(k_i) / FREQUENCY + abs(k_d) / t_f
    response = frequency_response(pid_model(gains), FREQUENCY)
    assert (np.abs(response - eq_4(S, gains)) <= 1e-12 * size + 1e-12).all()


def test_the_loop_is_the_product_of_eqs_1_to_4():
    model = PlantModel(lead_screw=LeadScrewParameters(3e-4))
    expected = eq_4(S, GAINS) * 3e-4 * eq_2(S, model.motor) * eq_3(S, model.structure)
    np.testing.assert_allclose(
        frequency_response(loop_transfer(model, GAINS), FREQUENCY), expected, rtol=1e-7
    )


def test_a_filter_in_series_is_a_factor_of_the_loop():
    notch = NotchFilter(27.0, 0.05, 0.6)
    factor = (S**2 + 2 * 0.05 * 27.0 * S + 27.0**2) / (S**2 + 2 * 0.6 * 27.0 * S + 27.0**2)
    expected = factor * frequency_response(loop_transfer(MODEL, GAINS), FREQUENCY)
    with_filter = frequency_response(loop_transfer(MODEL, GAINS, notch), FREQUENCY)
    np.testing.assert_allclose(with_filter, expected, rtol=1e-7)
    alone = frequency_response(notch_model(notch), FREQUENCY)
    np.testing.assert_allclose(alone, factor, rtol=1e-9)
    np.testing.assert_array_equal(frequency_response(notch_model(NO_NOTCH), FREQUENCY), 1.0)


def test_the_sampled_filter_is_close_to_the_continuous_one():
    notch, frequency = NotchFilter(27.0, 0.05, 0.6), np.linspace(2.0, 60.0, 200)
    plain, filtered = (
        frequency_response(sampled_loop_transfer(MODEL, GAINS, 500.0, one), frequency)
        for one in (NO_NOTCH, notch)
    )
    expected = frequency_response(notch_model(notch), frequency)
    np.testing.assert_allclose(filtered / plain, expected, rtol=0, atol=0.05)


def test_the_integral_action_takes_all_error_of_a_step_and_of_a_ramp():
    """The motor integrates and so does the controller: S falls with the square of frequency."""
    loop = loop_transfer(MODEL, GAINS)
    low = np.array([1e-3, 1e-2])
    sensitivity = np.abs(1 / (1 + frequency_response(loop, low)))
    assert sensitivity[0] < 1e-7
    assert sensitivity[1] / sensitivity[0] == pytest.approx(100.0, rel=1e-3)
    assert float(closed_loop(loop).dcgain()) == pytest.approx(1.0, abs=1e-9)


def test_the_plant_without_backlash_is_what_the_plant_core_simulates():
    step, state, positions = discretize_plant(MODEL, 2e-4), AT_REST, []
    for _ in range(5000):
        positions.append(state.structure.q3)
        state = plant_step(state, 0.5, 0.0, step)
    times = np.arange(5000) * 2e-4
    expected = control.forced_response(plant_model(MODEL), times, np.full(5000, 0.5)).outputs
    # Between samples the core moves d on a straight line: a second-order error in 0.2 ms.
    np.testing.assert_allclose(positions, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("notch", [NO_NOTCH, NotchFilter(27.0, 0.05, 0.6)])
def test_the_sampled_loop_is_what_the_cores_do_in_closed_loop(notch):
    plant, law = discretize_plant(MODEL, 2e-4), discretize_control(GAINS, 2e-3, notch)
    state, controller, positions = AT_REST, INITIAL_CONTROL, []
    for _ in range(1000):
        positions.append(state.structure.q3)
        controller, voltage = control_step(controller, 1e-3 - state.structure.q3, 0.0, law)
        for _ in range(10):
            state = plant_step(state, voltage, 0.0, plant)
    system = closed_loop(sampled_loop_transfer(MODEL, GAINS, 500.0, notch))
    times = np.arange(1000) * 2e-3
    expected = control.forced_response(system, times, np.full(1000, 1e-3)).outputs
    np.testing.assert_allclose(positions, expected, rtol=0, atol=1e-6 * 1e-3)


def test_a_fast_sampled_loop_comes_close_to_the_continuous_one():
    frequency = np.geomspace(0.5, 100.0, 50)
    continuous = frequency_response(loop_transfer(MODEL, GAINS), frequency)
    errors = []
    for rate in (1000.0, 4000.0):
        sampled = frequency_response(sampled_loop_transfer(MODEL, GAINS, rate), frequency)
        errors.append(np.abs(sampled / continuous - 1).max())
    # First order: the held voltage is late by half a period.
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def test_a_discrete_response_lies_on_the_unit_circle():
    system = control.ss(control.tf([0.5], [1, -0.5], 0.1))
    frequency = np.array([0.3, 3.0, 30.0])
    expected = 0.5 / (np.exp(0.1j * frequency) - 0.5)
    np.testing.assert_allclose(frequency_response(system, frequency), expected, rtol=1e-14)


LOOPS = {
    "continuous": loop_transfer(MODEL, GAINS),
    "sampled": sampled_loop_transfer(MODEL, GAINS, 500.0),
    "with feedthrough": pid_model(GAINS),
    "without states": notch_model(NO_NOTCH),
}


@pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)
def test_responses_and_poles_are_those_of_python_control(loop):
    at = np.exp(1j * FREQUENCY * loop.dt) if loop.isdtime(strict=True) else 1j * FREQUENCY
    np.testing.assert_allclose(frequency_response(loop, FREQUENCY), loop(at), rtol=1e-11)
    expected = np.sort_complex(control.feedback(loop, 1).poles())
    poles = np.sort_complex(closed_loop_poles(loop))
    np.testing.assert_allclose(poles, expected, rtol=1e-7)


@pytest.mark.parametrize(("gain", "stable"), [(1.0, True), (1.55, True), (1.60, False)])
def test_stability_is_that_of_the_roots_of_the_closed_loop(gain, stable):
    g = PidGains(gain * 3080.0, gain * 30800.0, gain * -308.4, 0.074)
    m, k, c = 5.2, 1e4, 36.9
    poly = np.polynomial.Polynomial
    k_p, k_i, k_d, t_f = g.proportional, g.integral, g.derivative, g.filter_time
    top = poly([k_i, k_p + k_i * t_f, k_p * t_f + k_d])
    top = top * poly([k, c]) ** 2 * 0.8 * (1e-3 / (2 * math.pi))
    bottom = poly([0, 0, 1, t_f]) * poly([0.08, 6e-5, 5e-9])
    bottom = bottom * poly([k**2, 2 * c * k, c**2 + 3 * k * m, 3 * c * m, m**2])
    assert ((top + bottom).roots().real < 0).all() == stable
    assert is_stable(loop_transfer(MODEL, g)) == stable
    # The sampled loop has its limit elsewhere, but not far.
    assert is_stable(sampled_loop_transfer(MODEL, g, 5000.0)) == stable
