"""The tower with stiffening beams, pushes and an elastic screw, against differential equations."""

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bdt_plant.stiffening_tower import BeamParameters, TowerState, discretize_tower, tower_step
from bdt_plant.structure import (
    StructureParameters,
    StructureState,
    discretize_structure,
    structure_step,
)

# Table 1, written again so that a wrong default is seen.
MASS, K, C = 5.2, 1e4, 36.9
CUBIC, SCREW = 2e7, 1e6
DURATION, STEPS = 0.4, 2000
REST = TowerState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def base(time):
    """Return position and velocity of the screw's end: 5 mm in a smooth step and back."""
    rate = np.pi / 0.15
    return 2.5e-3 * (1 - np.cos(rate * time)), 2.5e-3 * rate * np.sin(rate * time)


def run(screw=0.0, cubic=0.0, push_2=0.0, push_3=0.0, ratio=1.0, steps=STEPS):
    structure = StructureParameters(top_mass_ratio=ratio)
    step = discretize_tower(structure, BeamParameters(cubic), screw, DURATION / steps)
    tower, states = REST, []
    d = base(np.linspace(0.0, DURATION, steps + 1))[0].tolist()
    for before, after in itertools.pairwise(d):
        tower = tower_step(tower, before, after, push_2, push_3, step)
        states.append(tower)
    return np.array(states)


def solve(screw=0.0, cubic=0.0, push_2=0.0, push_3=0.0, ratio=1.0, steps=STEPS):
    def beam(x, v):
        return K * x + cubic * x**3 + C * v

    def rates(time, state):
        q1, v1, q2, v2, q3, v3 = state
        d, d_velocity = base(time)
        if not screw:
            q1, v1 = d, d_velocity
        lower, upper = beam(q1 - q2, v1 - v2), beam(q2 - q3, v2 - v3)
        a1 = (screw * (d - q1) - lower) / MASS
        return [v1, a1, v2, (lower - upper + push_2) / MASS, v3, (upper + push_3) / (ratio * MASS)]

    times = np.linspace(0.0, DURATION, steps + 1)
    solution = solve_ivp(
        rates, (0.0, DURATION), REST, "DOP853", times, rtol=1e-11, atol=1e-13, max_step=1e-3
    )
    return solution.y.T[1:]


EFFECTS = {
    "stiffening beams": {"cubic": CUBIC},
    "a push on platform 2": {"push_2": 5.0},
    "a push on platform 3": {"push_3": -5.0},
    "an elastic screw": {"screw": SCREW},
    "a payload": {"ratio": 1.4},
    "all of them": {"cubic": CUBIC, "push_2": 1.0, "push_3": -2.0, "screw": SCREW, "ratio": 0.8},
}


@pytest.mark.parametrize("effect", EFFECTS)
def test_the_platforms_move_as_the_differential_equations_say(effect):
    """Within 20 nm of several millimeters, at 5000 steps a second."""
    reference, core = solve(**EFFECTS[effect]), run(**EFFECTS[effect])
    linear = run()
    for column in (2, 4):
        assert np.abs(core[:, column] - reference[:, column]).max() < 2e-8
        assert np.abs(core[:, column] - linear[:, column]).max() > 1e-5  # it matters
    if "screw" in EFFECTS[effect]:
        assert np.abs(core[:, 0] - reference[:, 0]).max() < 2e-8


def test_the_error_is_of_second_order_in_the_step():
    effects = EFFECTS["all of them"]
    errors = [
        np.abs(run(**effects, steps=steps) - solve(**effects, steps=steps))[:, 4].max()
        for steps in (500, 1000, 2000)
    ]
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.2)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.2)


def test_with_nothing_that_eq_3_leaves_out_it_is_eq_3():
    step, structure = discretize_structure(StructureParameters(), DURATION / STEPS), []
    state = StructureState(0.0, 0.0, 0.0, 0.0)
    d = base(np.linspace(0.0, DURATION, STEPS + 1))[0].tolist()
    for before, after in itertools.pairwise(d):
        state = structure_step(state, before, after, step)
        structure.append(state)
    tower = run()
    np.testing.assert_allclose(tower[:, 2:], structure, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(tower[:, 0], d[1:])


def test_a_push_bends_the_tower_by_force_over_stiffness():
    """After the swing: both beams bear a push on platform 3."""
    step = discretize_tower(StructureParameters(), BeamParameters(), 0.0, 1e-3)
    tower = REST
    for _ in range(20_000):
        tower = tower_step(tower, 0.0, 0.0, 0.0, 2.0, step)
    assert tower.q2 == pytest.approx(2.0 / K, rel=1e-9)
    assert tower.q3 == pytest.approx(4.0 / K, rel=1e-9)


@pytest.mark.parametrize("value", [-1.0, np.inf])
def test_beams_that_soften_are_refused(value):
    with pytest.raises(ValueError, match=r"^BeamParameters\.cubic_stiffness = .*: must be"):
        BeamParameters(value)
