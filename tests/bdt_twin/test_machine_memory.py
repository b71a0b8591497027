"""What the twin keeps of a machine from window to window."""

import numpy as np
import pytest

from bdt_plant.motor import MotorParameters
from bdt_twin.machine_knowledge import ABSENT, EFFECT_SPREAD, EFFECTS, MachineKnowledge
from bdt_twin.machine_memory import EVIDENCE, MachineMemory
from bdt_twin.model_factors import FACTORS

FRICTION, OFFSET = (len(FACTORS) + EFFECTS.index(name) for name in EFFECTS[:2])
COUNT = len(FACTORS) + len(EFFECTS)


def told(offset=0.0, spread=1e-3):
    expected = np.zeros(COUNT)
    expected[OFFSET] = offset
    return MachineKnowledge(expected, spread**2 * np.eye(COUNT))


def evidence_of(name, gain):
    return np.where(np.array(EFFECTS) == name, gain, 0.0)


def spread_of(known, place):
    return np.sqrt(known.covariance[place, place])


def test_a_machine_has_no_effect_before_there_is_evidence():
    memory = MachineMemory(MotorParameters())
    assert not memory.has_evidence(evidence_of("voltage_offset", EVIDENCE))
    assert spread_of(memory.before(0.0), OFFSET) == pytest.approx(ABSENT * EFFECT_SPREAD[1])


def test_evidence_makes_one_effect_at_a_time_an_unknown():
    memory = MachineMemory(MotorParameters())
    both = evidence_of("voltage_offset", 9.0) + evidence_of("friction_voltage", 20.0)
    assert memory.has_evidence(both)
    assert spread_of(memory.before(0.0), FRICTION) == pytest.approx(EFFECT_SPREAD[0])
    assert spread_of(memory.before(0.0), OFFSET) == pytest.approx(ABSENT * EFFECT_SPREAD[1])
    assert memory.has_evidence(both)
    assert not memory.has_evidence(both)


def test_friction_of_the_model_is_an_unknown_from_the_beginning():
    motor = MotorParameters(coulomb_friction=0.01)
    known = MachineMemory(motor).before(0.0)
    assert known.expected[FRICTION] == pytest.approx(0.01 / 0.8 * 12.0)
    assert spread_of(known, FRICTION) == pytest.approx(EFFECT_SPREAD[0])


def test_only_windows_that_have_ended_before_count():
    memory = MachineMemory(MotorParameters())
    memory.has_evidence(evidence_of("voltage_offset", 9.0))
    memory.learn(20.0, told(0.02))
    memory.learn(21.0, told(0.03))
    assert memory.before(20.0).expected[OFFSET] == 0.0
    assert memory.before(20.5).expected[OFFSET] == 0.02
    assert memory.before(30.0).expected[OFFSET] == 0.03


def test_an_effect_found_later_was_not_told_of_before():
    memory = MachineMemory(MotorParameters())
    memory.learn(20.0, told(spread=1e-9))
    memory.has_evidence(evidence_of("voltage_offset", 9.0))
    assert spread_of(memory.before(25.0), OFFSET) == pytest.approx(EFFECT_SPREAD[1])


def test_what_was_told_makes_nothing_less_sure_than_nothing_told():
    memory = MachineMemory(MotorParameters())
    memory.has_evidence(evidence_of("voltage_offset", 9.0))
    first = memory.before(0.0).covariance
    memory.learn(20.0, told(spread=10.0))
    assert (np.diag(memory.before(1e6).covariance) <= np.diag(first) * (1 + 1e-12)).all()


@pytest.mark.parametrize(
    ("voltage", "spread", "is_stated"),
    [(0.02, 1e-3, True), (-0.02, 1e-3, True), (0.004, 1e-3, False), (9e-4, 1e-6, False)],
)
def test_an_offset_is_stated_once_it_is_told_from_none(voltage, spread, is_stated):
    memory = MachineMemory(MotorParameters())
    stated = memory.voltage_offset(told(voltage, spread))
    assert stated == ((voltage, pytest.approx(spread)) if is_stated else None)


def test_an_offset_that_was_stated_is_stated_when_it_has_become_small():
    memory = MachineMemory(MotorParameters())
    memory.voltage_offset(told(0.02))
    assert memory.voltage_offset(told(1e-4)).voltage == 1e-4
