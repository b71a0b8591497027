"""The structure against eq. 3 of the paper, transformed and integrated by other means."""

from itertools import pairwise

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bdt_plant.structure import (
    StructureParameters,
    StructureState,
    discretize_structure,
    structure_step,
)

# Table 1 and the coefficients of eq. 3, written again.
M, K, C = 5.2, 1e4, 36.9
DENOMINATOR = [M**2, 3 * C * M, C**2 + 3 * K * M, 2 * C * K, K**2]
EQ_3 = control.tf([C**2, 2 * C * K, K**2], DENOMINATOR)
# Platform 3 hangs on platform 2 alone: q3 / q2 = (c s + k) / (m s^2 + c s + k).
EQ_3_Q2 = control.tf(np.polymul([C, K], [M, C, K]), DENOMINATOR)
DERIVATIVE = control.tf([1, 0], [1])
SAMPLE_TIME = 2e-4
AT_REST = StructureState(0.0, 0.0, 0.0, 0.0)


def run(base, sample_time=SAMPLE_TIME, state=AT_REST, structure=None):
    """Return (q2, q2', q3, q3') at every point of `base`, shape (n, 4)."""
    step = discretize_structure(structure or StructureParameters(), sample_time)
    states = [state]
    for before, after in pairwise(base.tolist()):
        state = structure_step(state, before, after, step)
        states.append(state)
    return np.array(states)


def corners(count, sample_time):
    """Return a base that moves in straight lines between random points 5 mm around zero."""
    base = np.random.default_rng(2).uniform(-5e-3, 5e-3, count)
    base[0] = 0.0
    return np.arange(count) * sample_time, base


def test_a_ramp_of_the_base_gives_the_ramp_response_of_eq_3_at_every_sample():
    times = np.arange(5001) * SAMPLE_TIME
    # The ramp response is the step response of eq. 3 divided by s.
    expected = 0.02 * control.step_response(EQ_3 / DERIVATIVE, times).outputs
    # 20 mm after a second; 1e-12 m is rounding.
    np.testing.assert_allclose(run(0.02 * times)[:, 2], expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("sample_time", [2e-4, 2e-3, 5e-2])
@pytest.mark.parametrize(
    ("component", "transfer_function"),
    [(0, EQ_3_Q2), (1, EQ_3_Q2 * DERIVATIVE), (2, EQ_3), (3, EQ_3 * DERIVATIVE)],
    ids=["q2", "q2_velocity", "q3", "q3_velocity"],
)
def test_a_base_that_moves_in_straight_lines_gives_the_response_of_eq_3(
    component, transfer_function, sample_time
):
    times, base = corners(500, sample_time)
    # python-control joins the inputs by straight lines, too.
    expected = control.forced_response(transfer_function, times, base).outputs
    error = np.abs(run(base, sample_time)[:, component] - expected).max()
    assert error <= 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("ratio", [1.0, 0.7, 1.5])
def test_the_response_is_that_of_the_integrated_equations_of_motion(ratio):
    _, base = corners(100, 2e-3)
    state, expected = np.zeros(4), [np.zeros(4)]
    for before, after in pairwise(base):
        velocity = (after - before) / 2e-3

        def rates(time, x, before=before, velocity=velocity):
            q1 = before + velocity * time
            q2, v2, q3, v3 = x
            lower = K * (q1 - q2) + C * (velocity - v2)
            upper = K * (q2 - q3) + C * (v2 - v3)
            return [v2, (lower - upper) / M, v3, upper / (ratio * M)]

        state = solve_ivp(rates, (0, 2e-3), state, "DOP853", rtol=1e-10, atol=1e-14).y[:, -1]
        expected.append(state)
    expected = np.array(expected)
    structure = StructureParameters(top_mass_ratio=ratio)
    error = np.abs(run(base, 2e-3, structure=structure) - expected).max(axis=0)
    assert (error <= 1e-9 * np.abs(expected).max(axis=0)).all()


def test_a_base_at_rest_ends_with_every_platform_above_it():
    q2, v2, q3, v3 = run(np.full(100_000, 5e-3))[-1]
    assert q2 == pytest.approx(5e-3, rel=1e-9)
    assert q3 == pytest.approx(5e-3, rel=1e-9)
    assert abs(v2) + abs(v3) < 1e-12


def test_a_displaced_structure_at_rest_stays_at_rest():
    states = run(np.full(1000, 5e-3), state=StructureState(5e-3, 0.0, 5e-3, 0.0))
    np.testing.assert_allclose(states[:, [0, 2]], 5e-3, rtol=1e-12)


def modes(structure):
    """Return natural frequencies [rad/s], rising, and damping ratios, from the discrete model."""
    step = discretize_structure(structure, SAMPLE_TIME)
    one_sample = np.array([row[:4] for row in step])
    poles = np.log(np.linalg.eigvals(one_sample).astype(complex)) / SAMPLE_TIME
    poles = sorted(poles[poles.imag > 0], key=abs)
    return [abs(pole) for pole in poles], [-pole.real / abs(pole) for pole in poles]


def test_the_first_mode_lies_at_27_rad_a_second_with_5_percent_damping():
    frequencies, dampings = modes(StructureParameters())
    # Closed form of a two-storey shear frame: omega = sqrt(k / m) (sqrt(5) -+ 1) / 2.
    golden = (np.sqrt(5) + np.array([-1, 1])) / 2
    np.testing.assert_allclose(frequencies, np.sqrt(K / M) * golden, rtol=1e-9)
    np.testing.assert_allclose(dampings, C / (2 * np.sqrt(K * M)) * golden, rtol=1e-9)
    swings = frequencies[0] * np.sqrt(1 - dampings[0] ** 2)
    assert swings == pytest.approx(27.07, abs=0.005)
    assert dampings[0] == pytest.approx(0.05, abs=5e-4)


@pytest.mark.parametrize("ratio", [0.5, 1.2, 3.0])
def test_modes_of_unequal_masses_are_those_of_the_characteristic_equation(ratio):
    frequencies, _ = modes(StructureParameters(damping=0.0, top_mass_ratio=ratio))
    squares = np.roots([1.0, -(2.0 + 1.0 / ratio) * K / M, (K / M) ** 2 / ratio])
    np.testing.assert_allclose(frequencies, np.sqrt(np.sort(squares)), rtol=1e-8)


def test_the_poles_are_those_of_eq_3():
    step = discretize_structure(StructureParameters(), SAMPLE_TIME)
    found = np.poly(np.array([row[:4] for row in step]))
    expected = np.poly(np.exp(np.roots(DENOMINATOR) * SAMPLE_TIME))
    np.testing.assert_allclose(found, expected, rtol=1e-11)


def test_without_dissipation_the_energy_stays():
    structure = StructureParameters(damping=0.0)
    start = StructureState(5e-3, 0.1, -3e-3, 0.2)
    q2, v2, q3, v3 = run(np.zeros(20_000), state=start, structure=structure).T
    energy = K / 2 * (q2**2 + (q3 - q2) ** 2) + M / 2 * (v2**2 + v3**2)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)


@pytest.mark.parametrize("name", ["mass", "stiffness", "top_mass_ratio"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf"), "5", True])
def test_a_mass_or_stiffness_that_no_structure_has_is_refused(name, value):
    with pytest.raises(ValueError, match=rf"StructureParameters\.{name} = .*must be .* to "):
        StructureParameters(**{name: value})


def test_negative_damping_is_refused():
    with pytest.raises(ValueError, match=r"StructureParameters\.damping = -0\.1 N s/m: must be 0"):
        StructureParameters(damping=-0.1)
