"""Predicted limit cycles against closed forms written out once more."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import fsolve

from bdt_controller.pid import PidGains
from bdt_plant.plant import PlantModel
from bdt_plant.structure import StructureParameters
from bdt_study.limit_cycles.harmonic_balance import (
    describing_function_cycle,
    harmonic_balance_cycle,
)

MODEL = PlantModel()
GAINS = PidGains(3080.0, 30800.0, -308.4, 0.074)
GAP = math.radians(10.0)
PITCH = 1e-3 / (2 * math.pi)


def structure_at(frequency):
    s, m, k, c = 1j * frequency, 5.2, 1e4, 36.9
    rest = 3 * c * m * s**3 + (c**2 + 3 * k * m) * s**2 + 2 * c * k * s + k**2
    return (c * s + k) ** 2 / (m**2 * s**4 + rest)


def loop_at(frequency):
    s = 1j * frequency
    controller = 3080.0 + 30800.0 / s - 308.4 * s / (0.074 * s + 1)
    motor = 0.8 / (5e-9 * s**2 + 6e-5 * s + 0.08) / s
    return controller * motor * PITCH * structure_at(frequency)


def play_of_a_sine(amplitude, gap, points=20000):
    """Return the first harmonic of the play of A cos over A, from the hysteresis loop's geometry.

    theta_d is A cos x + gap / 2 while the motor comes down in contact, and rests after a turn
    until the motor has crossed the gap.
    """
    x = 2 * math.pi * (np.arange(points) + 0.5) / points
    motor, top = amplitude * np.cos(x), amplitude - gap / 2
    falling = x < math.pi
    output = np.where(falling, np.minimum(top, motor + gap / 2), np.maximum(-top, motor - gap / 2))
    return 2 * np.mean(output * np.exp(-1j * x)) / amplitude


def test_the_describing_function_solves_the_balance_of_the_fundamental():
    def balance(unknown):
        value = loop_at(unknown[0]) * play_of_a_sine(unknown[1] * GAP, GAP) + 1
        return [value.real, value.imag]

    frequency, amplitude = fsolve(balance, [8.0, 2.0])
    screw = abs(play_of_a_sine(amplitude * GAP, GAP)) * amplitude * GAP
    expected = PITCH * screw * abs(structure_at(frequency))
    cycle = describing_function_cycle(MODEL, GAINS, GAP)
    assert cycle.frequency == pytest.approx(frequency, rel=1e-4)
    assert cycle.fundamental == pytest.approx(expected, rel=1e-4)
    assert cycle.peak_to_peak == 2 * cycle.fundamental


def test_the_harmonic_balance_of_the_fundamental_alone_is_the_describing_function():
    predicted = describing_function_cycle(MODEL, GAINS, GAP)
    balanced = harmonic_balance_cycle(MODEL, GAINS, GAP, highest_harmonic=1)
    assert balanced.frequency == pytest.approx(predicted.frequency, rel=1e-4)
    assert balanced.fundamental == pytest.approx(predicted.fundamental, rel=1e-3)
    assert balanced.third_harmonic == 0.0


def test_more_harmonics_change_less_and_less():
    cycles = [harmonic_balance_cycle(MODEL, GAINS, GAP, highest) for highest in (3, 9, 15, 21)]
    sizes = np.array([cycle.peak_to_peak for cycle in cycles])
    changes = np.abs(np.diff(sizes)) / sizes[-1]
    assert (np.diff(changes) < 0).all()
    assert changes[-1] < 1e-4


@pytest.mark.parametrize("cycle_of", [describing_function_cycle, harmonic_balance_cycle])
def test_the_limit_cycle_is_proportional_to_the_gap(cycle_of):
    small, large = cycle_of(MODEL, GAINS, GAP), cycle_of(MODEL, GAINS, 3 * GAP)
    assert large.gap == 3 * small.gap
    assert large.frequency == pytest.approx(small.frequency, rel=1e-4)
    assert large.fundamental == pytest.approx(3 * small.fundamental, rel=1e-3)
    assert large.peak_to_peak == pytest.approx(3 * small.peak_to_peak, rel=1e-3)


@pytest.mark.parametrize("cycle_of", [describing_function_cycle, harmonic_balance_cycle])
def test_a_slow_loop_without_integral_action_has_no_limit_cycle(cycle_of):
    """P control of an integrator: L stays away from -1 / N, whose phase is -90 to -180 degrees."""
    assert cycle_of(MODEL, PidGains(300.0, 0.0, 0.0, 0.1), GAP) is None


@pytest.mark.parametrize("cycle_of", [describing_function_cycle, harmonic_balance_cycle])
def test_a_loop_that_is_unstable_without_backlash_has_no_prediction(cycle_of):
    hot = replace(GAINS, proportional=2 * 3080.0, integral=2 * 30800.0, derivative=2 * -308.4)
    assert cycle_of(MODEL, hot, GAP) is None


def test_without_a_structure_in_the_way_both_predictions_come_close():
    stiff = replace(MODEL, structure=StructureParameters(stiffness=1e6, damping=369.0))
    predicted = describing_function_cycle(stiff, GAINS, GAP)
    balanced = harmonic_balance_cycle(stiff, GAINS, GAP)
    assert predicted.frequency == pytest.approx(balanced.frequency, rel=0.01)
    assert predicted.fundamental == pytest.approx(balanced.fundamental, rel=0.03)
