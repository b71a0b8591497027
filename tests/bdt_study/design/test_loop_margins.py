"""Margins against closed forms and against python-control."""

import math

import control
import numpy as np
import pytest

from bdt_controller.pid import PidGains
from bdt_plant.plant import PlantModel
from bdt_study.design.linear_model import (
    frequency_response,
    is_stable,
    loop_transfer,
    sampled_loop_transfer,
)
from bdt_study.design.loop_margins import characteristic_frequencies, loop_margins

GAINS = PidGains(3080.0, 30800.0, -308.4, 0.074)
LOOP = loop_transfer(PlantModel(), GAINS)
SAMPLED = sampled_loop_transfer(PlantModel(), GAINS, 500.0)


def system(top, bottom, period=0):
    return control.ss(control.tf(top, bottom, period))


def test_a_motor_with_friction():
    """L = 1 / (s (s + 1)): |L| = 1 where w^4 + w^2 = 1, and S, T are those of two poles."""
    margins = loop_margins(system([1], [1, 1, 0]))
    crossover = math.sqrt((math.sqrt(5) - 1) / 2)
    assert margins.stable
    assert margins.first_crossover == pytest.approx(crossover, rel=1e-8)
    assert margins.smallest_phase_margin == pytest.approx(math.atan(1 / crossover), rel=1e-8)
    assert margins.gain_margin == math.inf
    # |T|^2 = 1 / ((1 - w^2)^2 + w^2) = 1/2 at w^2 = (1 + sqrt 5) / 2.
    assert margins.bandwidth == pytest.approx(math.sqrt((1 + math.sqrt(5)) / 2), rel=1e-8)
    w = np.linspace(0.5, 5, 200001)
    highest = np.abs((1j * w - w**2) / (1 + 1j * w - w**2)).max()
    assert margins.maximum_sensitivity == pytest.approx(highest, rel=1e-8)


def test_three_poles_have_a_gain_margin():
    """L = 2 / (s (s + 1) (s + 2)) is -1/3 at the root of 2."""
    assert loop_margins(system([2], [1, 3, 2, 0])).gain_margin == pytest.approx(3.0, rel=1e-8)


def test_less_gain_is_the_danger_of_a_conditionally_stable_loop():
    """L = 10 (s + 1)^2 / s^3 is -20 at 1 rad/s."""
    margins = loop_margins(system([10, 20, 10], [1, 0, 0, 0]))
    assert margins.stable
    assert margins.gain_margin == pytest.approx(1 / 20, rel=1e-7)


def test_python_control_finds_the_same_margins():
    margins = loop_margins(LOOP)
    gains, phase, _, turns, crossovers, _ = control.stability_margins(LOOP, returnall=True)
    # The double pole at 0 can leave python-control a root at 1e-6 rad/s; that is the rounding
    # of its polynomials and depends on the processor.
    gain = gains[turns > 1e-3]
    distance = control.stability_margins(LOOP)[2]
    assert [each.frequency for each in margins.crossovers] == pytest.approx(crossovers, rel=1e-6)
    degrees = [math.degrees(each.phase_margin) for each in margins.crossovers]
    assert degrees == pytest.approx(phase, abs=1e-4)
    assert margins.gain_margin == pytest.approx(min(gain), rel=1e-6)
    assert margins.maximum_sensitivity == pytest.approx(1 / distance, rel=1e-6)


@pytest.mark.parametrize("loop", [LOOP, SAMPLED], ids=["continuous", "sampled"])
def test_the_gain_margin_is_where_the_closed_loop_loses_stability(loop):
    margin = loop_margins(loop).gain_margin
    assert is_stable(loop * (0.999 * margin))
    assert not is_stable(loop * (1.001 * margin))


@pytest.mark.parametrize("loop", [LOOP, SAMPLED], ids=["continuous", "sampled"])
def test_turning_the_loop_by_a_phase_margin_leads_through_minus_one(loop):
    crossovers = loop_margins(loop).crossovers
    assert len(crossovers) == 3
    for crossover in crossovers:
        value = frequency_response(loop, np.array([crossover.frequency]))[0]
        assert value * np.exp(-1j * crossover.phase_margin) == pytest.approx(-1.0, abs=1e-6)


def test_sampling_costs_next_to_nothing_at_500_hz():
    continuous, sampled = loop_margins(LOOP), loop_margins(SAMPLED)
    assert sampled.stable
    assert sampled.smallest_phase_margin == pytest.approx(
        continuous.smallest_phase_margin, rel=0.01
    )
    assert sampled.maximum_sensitivity == pytest.approx(continuous.maximum_sensitivity, rel=0.01)


def test_the_frequencies_resolve_the_sharpest_resonance():
    sharp = system([1e-4], [1, 2e-4, 1, 0])
    frequency = characteristic_frequencies(sharp)
    near = frequency[(frequency > 1 - 1e-4) & (frequency < 1 + 1e-4)]
    assert near.size > 20
    assert (np.diff(frequency) > 0).all()


def test_sampled_frequencies_end_at_the_nyquist_frequency():
    assert characteristic_frequencies(SAMPLED)[-1] < math.pi * 500.0
