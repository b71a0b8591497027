"""What simulated steps come to, told by signals that are known."""

import math

import numpy as np
import pytest

from bdt_controller.control_law import discretize_control
from bdt_controller.pid import PidGains
from bdt_plant.plant import PlantModel, discretize_plant
from bdt_twin.decision_loop import HOLD, Member
from bdt_twin.simulated_outcome import FAILED, StepTrials, is_limit_cycle

TIME = np.arange(4000) / 500.0
HEIGHT = 5e-3
BUSY = np.ones(TIME.size)
RATE = 500.0
LAW = discretize_control(PidGains(), 1.0 / RATE)
PITCH = PlantModel().lead_screw.pitch
GAP = math.radians(20.0)
MEMBER = Member(discretize_plant(PlantModel(), 1.0 / (HOLD * RATE)), GAP, 0.0, 0, 0.3)


def test_an_oscillation_that_stays_is_a_limit_cycle():
    assert is_limit_cycle(HEIGHT + 1e-4 * np.sin(9.0 * TIME), BUSY, HEIGHT)


@pytest.mark.parametrize(
    ("position", "voltage"),
    [
        (HEIGHT + 1e-5 * np.sin(9.0 * TIME), BUSY),
        (HEIGHT + HEIGHT * np.exp(-TIME) * np.sin(27.0 * TIME), BUSY),
        (HEIGHT + 1e-4 * np.sin(9.0 * TIME), 0.0 * BUSY),
    ],
    ids=["small", "dying out", "of the structure alone, in the dead zone"],
)
def test_other_motions_are_none(position, voltage):
    assert not is_limit_cycle(position, voltage, HEIGHT)


def test_a_loop_without_dead_zone_fails_and_one_with_a_wide_one_does_not():
    trials = StepTrials([HEIGHT, 8e-3], 8.0, RATE, 0.0)
    assert trials.outcome([MEMBER], LAW, 1e-9) == FAILED
    found = trials.outcome([MEMBER], LAW, 1.5 * PITCH * GAP)
    assert not found.failed
    assert found.bias <= 1.5 * PITCH * GAP / HEIGHT
    assert 0.5 < found.settling <= found.longest < 8.0


def test_an_unstable_loop_fails():
    wild = discretize_control(PidGains(1e6), 1.0 / RATE)
    assert StepTrials([HEIGHT], 8.0, RATE, 0.0).outcome([MEMBER], wild, 1e-5) == FAILED


def test_one_mechanism_that_fails_is_enough():
    trials = StepTrials([HEIGHT], 8.0, RATE, 0.0)
    worn = MEMBER._replace(gap=4.0 * GAP)
    assert not trials.outcome([MEMBER], LAW, PITCH * GAP).failed
    assert trials.outcome([MEMBER, worn], LAW, PITCH * GAP) == FAILED
