"""What the twin keeps of a machine from window to window."""

import numpy as np
import pytest

from bdt_plant.motor import MotorParameters
from bdt_twin.cogging_search import CoggingEvidence
from bdt_twin.effect_trials import LATE_VOLTAGE, OTHER_TOP_MASS, THREAD_ERROR, TRIALS, TRIED_AGAIN
from bdt_twin.innovations import NoiseLevels
from bdt_twin.machine_knowledge import (
    ABSENT,
    COGGING,
    EFFECT_SPREAD,
    EFFECTS,
    TOP_MASS,
    YIELD_ANGLE,
    MachineKnowledge,
)
from bdt_twin.machine_memory import (
    COGGING_EVIDENCE,
    EVIDENCE,
    OTHER_EVIDENCE,
    PLAUSIBLE,
    SEARCH_AGAIN,
    SEARCH_EVERY,
    WITH_FRICTION,
    MachineMemory,
)
from bdt_twin.model_factors import FACTORS
from bdt_twin.unknowns import INITIAL_CONDITION, LATE, Unknowns

FRICTION, OFFSET = (len(FACTORS) + EFFECTS.index(name) for name in EFFECTS[:2])
DELAY = len(FACTORS) + EFFECTS.index("delay")
COUNT = len(FACTORS) + len(EFFECTS)


WITHOUT_EFFECTS = Unknowns(
    np.ones(2), np.zeros(len(FACTORS)), np.zeros((1, len(INITIAL_CONDITION)))
)
NO_EVIDENCE = np.zeros(len(EFFECTS))
RESTLESS, AT_REST = NoiseLevels(1e-6, slow=1e-4), NoiseLevels(1e-6, slow=1e-7)


def told(offset=0.0, spread=1e-3, friction=0.0):
    expected = np.zeros(COUNT)
    expected[OFFSET], expected[FRICTION] = offset, friction
    return MachineKnowledge(expected, spread**2 * np.eye(COUNT))


def evidence_of(name, gain):
    return np.where(np.array(EFFECTS) == name, gain, 0.0)


def spread_of(known, place):
    return np.sqrt(known.covariance[place, place])


def test_a_machine_has_no_effect_before_there_is_evidence():
    memory = MachineMemory(MotorParameters())
    assert not memory.has_evidence(evidence_of("voltage_offset", EVIDENCE), told())
    assert spread_of(memory.before(0.0, 0.0), OFFSET) == pytest.approx(ABSENT * EFFECT_SPREAD[1])


def test_evidence_makes_one_effect_at_a_time_an_unknown():
    memory = MachineMemory(MotorParameters())
    both = evidence_of("voltage_offset", 9.0) + evidence_of("friction_voltage", 20.0)
    assert memory.has_evidence(both, told())
    assert spread_of(memory.before(0.0, 0.0), FRICTION) == pytest.approx(EFFECT_SPREAD[0])
    assert spread_of(memory.before(0.0, 0.0), OFFSET) == pytest.approx(ABSENT * EFFECT_SPREAD[1])
    assert memory.has_evidence(both, told())
    assert not memory.has_evidence(both, told())


def test_friction_of_the_model_is_an_unknown_from_the_beginning():
    motor = MotorParameters(coulomb_friction=0.01)
    known = MachineMemory(motor).before(0.0, 0.0)
    assert known.expected[FRICTION] == pytest.approx(0.01 / 0.8 * 12.0)
    assert spread_of(known, FRICTION) == pytest.approx(EFFECT_SPREAD[0])


@pytest.mark.parametrize(
    ("friction", "spread", "is_certain"),
    [(0.15, 1e-3, True), (0.15, 0.05, False), (0.01, 1e-6, False)],
)
def test_a_motor_with_certain_friction_has_all_that_friction_has(friction, spread, is_certain):
    memory = MachineMemory(MotorParameters())
    memory.has_evidence(evidence_of("friction_voltage", 20.0), told())
    joined = memory.has_evidence(NO_EVIDENCE, told(friction=friction, spread=spread))
    assert joined == is_certain
    known = memory.before(0.0, 0.0)
    for name in WITH_FRICTION:
        place = EFFECTS.index(name)
        expected = EFFECT_SPREAD[place] * (1.0 if is_certain else ABSENT)
        assert spread_of(known, len(FACTORS) + place) == pytest.approx(expected)
    assert not memory.has_evidence(NO_EVIDENCE, told(friction=friction, spread=spread))


@pytest.mark.parametrize("name", ["friction_growth", "friction_slope"])
def test_friction_has_to_be_certain_before_it_changes(name):
    memory, place = MachineMemory(MotorParameters()), len(FACTORS) + EFFECTS.index(name)
    changes = evidence_of(name, EVIDENCE + 1.0)
    memory.has_evidence(evidence_of("friction_voltage", 20.0), told())
    assert not memory.has_evidence(changes, told(friction=0.15, spread=0.05))
    certain = told(friction=0.15)
    assert memory.has_evidence(NO_EVIDENCE, certain), "what all friction has joins first"
    assert not memory.has_evidence(evidence_of(name, EVIDENCE), certain)
    assert memory.has_evidence(changes, certain)
    assert spread_of(memory.before(0.0, 0.0), place) == pytest.approx(
        EFFECT_SPREAD[EFFECTS.index(name)]
    )
    assert not memory.has_evidence(changes, certain)


def test_friction_that_was_changing_has_gone_on_to_the_end_of_the_window():
    memory = MachineMemory(MotorParameters(coulomb_friction=0.01))
    growth = len(FACTORS) + EFFECTS.index("friction_growth")
    known = told(friction=0.15)
    memory.has_evidence(NO_EVIDENCE, known)
    memory.has_evidence(evidence_of("friction_growth", EVIDENCE + 1.0), known)
    known.expected[growth] = -5e-3
    memory.learn(10.0, known)
    assert memory.before(10.5, 20.0).expected[FRICTION] == pytest.approx(0.15 * (1.0 - 0.05))


def with_certain_friction():
    memory = MachineMemory(MotorParameters(coulomb_friction=0.01))
    memory.has_evidence(NO_EVIDENCE, told(friction=0.15))
    return memory


@pytest.mark.parametrize(("friction", "spread"), [(0.015, 1e-3), (0.15, 0.05)])
def test_little_friction_may_be_cogging_and_unsure_friction_none(friction, spread):
    memory = with_certain_friction()
    assert memory.has_friction(told(friction=0.15))
    assert not memory.has_friction(told(friction=friction, spread=spread))
    assert memory.has_friction(told(friction=0.015), least=0.01)


YIELD_PLACE = len(FACTORS) + YIELD_ANGLE


def learned(memory):
    """Let a window tell something that ends before the one that is asked for."""
    memory.learn(1.0, told(friction=0.15))
    return memory


def test_what_was_told_of_rigid_friction_is_forgotten_where_it_yields():
    memory = learned(with_certain_friction())
    assert spread_of(memory.before(1.5, 20.0), FRICTION) < EFFECT_SPREAD[0]
    other = memory.with_yield_angle(3e-3)
    known = other.before(1.5, 20.0)
    assert spread_of(known, FRICTION) == pytest.approx(EFFECT_SPREAD[0])
    assert spread_of(known, YIELD_PLACE) == pytest.approx(EFFECT_SPREAD[YIELD_ANGLE])
    assert known.expected[YIELD_PLACE] == 3e-3
    assert other.present == memory.present | {YIELD_ANGLE}
    assert YIELD_ANGLE not in memory.present, "it is another machine"


def test_friction_that_yields_is_rigid_again_for_an_angle_of_zero():
    other = learned(with_certain_friction()).with_yield_angle(3e-3).with_yield_angle(0.0)
    known = other.before(1.5, 20.0)
    assert known.expected[YIELD_PLACE] == 0.0
    assert spread_of(known, YIELD_PLACE) == pytest.approx(ABSENT * EFFECT_SPREAD[YIELD_ANGLE])


def test_a_machine_with_other_friction_has_the_effects_that_are_found_later():
    memory = with_certain_friction()
    rigid, other = memory.with_yield_angle(0.0), memory.with_yield_angle(3e-3)
    memory.has_cogging(24)
    rigid.be_like(memory)
    other.be_like(memory)
    assert other.cogs == rigid.cogs == 24
    assert rigid.present == memory.present
    assert other.present == memory.present | {YIELD_ANGLE}
    memory.be_like(other)
    assert YIELD_ANGLE not in memory.present


def told_late(delay=2.0 * LATE):
    machine = told()
    machine.expected[DELAY] = delay
    return machine


def test_what_shows_no_evidence_is_tried_where_the_motor_walks():
    memory = MachineMemory(MotorParameters())
    assert memory.to_try(AT_REST, told_late()) is None
    tried = [memory.to_try(RESTLESS, told_late()) for _ in TRIALS]
    assert tried == list(TRIALS)


@pytest.mark.parametrize("trial", TRIALS)
def test_what_was_told_without_an_effect_is_forgotten_once_it_is_there(trial):
    memory, sizes = MachineMemory(MotorParameters()), 1e-3 * np.arange(len(EFFECTS))
    memory.has_evidence(evidence_of("delay", 9.0), told())
    memory.learn(1.0, told_late())
    tried = memory.with_effects(sizes, trial.places)
    assert memory.before(2.0, 3.0).expected[DELAY] == 2.0 * LATE
    memory.has_effects(sizes, trial.places)
    for known in (tried, memory.before(2.0, 3.0)):
        assert known.expected[DELAY] == 0.0
        for effect in trial.places:
            place = len(FACTORS) + effect
            assert known.expected[place] == sizes[effect]
            assert spread_of(known, place) == pytest.approx(EFFECT_SPREAD[effect])
    assert memory.present.issuperset(trial.places)
    assert trial not in [memory.to_try(RESTLESS, told_late()) for _ in range(9)]


def test_what_has_failed_is_tried_at_once_on_a_machine_that_is_another_one():
    """With a payload and a late voltage the one was not told from the other, and then not tried."""
    memory = MachineMemory(MotorParameters())
    for _ in range(9 * TRIED_AGAIN):
        memory.to_try(RESTLESS, told_late())
    memory.has_effects(np.zeros(len(EFFECTS)), OTHER_TOP_MASS.places)
    assert memory.to_try(RESTLESS, told_late()) is LATE_VOLTAGE
    memory.has_cogging(24)
    assert memory.to_try(RESTLESS, told_late()) is LATE_VOLTAGE


def test_what_a_machine_has_is_never_expected_to_be_nothing_a_fit_would_stay_there():
    memory, found = MachineMemory(MotorParameters()), np.zeros(len(EFFECTS))
    found[TOP_MASS] = 0.2
    memory.has_effects(found, OTHER_TOP_MASS.places)
    place = len(FACTORS) + TOP_MASS
    assert memory.before(0.0, 0.0).expected[place] == 0.2
    memory.has_effects(found, THREAD_ERROR.places)
    assert memory.before(0.0, 0.0).expected[place] == 0.2, "it is still found"
    other = memory.with_yield_angle(2e-3).before(0.0, 0.0)
    for tried in (OTHER_TOP_MASS, THREAD_ERROR):
        begun = tried.begun(WITHOUT_EFFECTS).effects
        for each in tried.places:
            assert other.expected[len(FACTORS) + each] == begun[each]


def test_cogging_is_looked_for_where_the_motor_walks_now_and_then():
    memory = MachineMemory(MotorParameters())
    assert not memory.looks_for_cogging(AT_REST)
    looked = [memory.looks_for_cogging(RESTLESS) for _ in range(2 * SEARCH_EVERY)]
    assert sum(looked) == 2
    assert looked[0]


def test_cogging_joins_on_evidence_with_its_number_of_periods():
    memory = MachineMemory(MotorParameters())
    assert not memory.suspects_cogging(CoggingEvidence(23, COGGING_EVIDENCE))
    assert memory.suspects_cogging(CoggingEvidence(24, COGGING_EVIDENCE + 1.0))
    assert memory.cogs == 0
    memory.has_cogging(24)
    assert memory.cogs == 24
    for place in COGGING:
        assert spread_of(memory.before(0.0, 0.0), len(FACTORS) + place) == EFFECT_SPREAD[place]


def test_another_number_of_periods_is_looked_for_later_where_one_was_no_better():
    memory = MachineMemory(MotorParameters())
    memory.has_cogging(24)
    assert memory.suspects_cogging(CoggingEvidence(12, OTHER_EVIDENCE + 1.0))
    assert memory.looks_for_cogging(RESTLESS)
    memory.keeps_cogging()
    looked = [memory.looks_for_cogging(RESTLESS) for _ in range(SEARCH_AGAIN)]
    assert looked == [False] * (SEARCH_AGAIN - 1) + [True]


def test_what_was_known_of_cogging_is_forgotten_with_another_number_of_periods():
    memory = MachineMemory(MotorParameters(coulomb_friction=0.01))
    memory.has_cogging(12)
    known = told(friction=0.15, spread=1e-4)
    places = [len(FACTORS) + place for place in sorted(COGGING)]
    known.expected[places] = 0.02, -0.01
    memory.learn(10.0, known)
    assert memory.before(10.5, 20.0).expected[places] == pytest.approx([0.02, -0.01])
    memory.has_cogging(24)
    later = memory.before(10.5, 20.0)
    assert not later.expected[places].any()
    for place, effect in zip(places, sorted(COGGING), strict=True):
        assert spread_of(later, place) == EFFECT_SPREAD[effect]
    assert later.expected[FRICTION] == pytest.approx(0.15)


@pytest.mark.parametrize("name", EFFECTS)
def test_a_constant_that_no_machine_has_is_named(name):
    memory, machine, place = MachineMemory(MotorParameters()), told(), EFFECTS.index(name)
    for share, named in ((0.9, ""), (1.1, name.replace("_", " "))):
        machine.expected[len(FACTORS) + place] = share * PLAUSIBLE * EFFECT_SPREAD[place]
        assert memory.implausible(machine) == named


def test_only_windows_that_have_ended_before_count():
    memory = MachineMemory(MotorParameters())
    memory.has_evidence(evidence_of("voltage_offset", 9.0), told())
    memory.learn(20.0, told(0.02))
    memory.learn(21.0, told(0.03))
    assert memory.before(20.0, 20.0).expected[OFFSET] == 0.0
    assert memory.before(20.5, 20.5).expected[OFFSET] == 0.02
    assert memory.before(30.0, 30.0).expected[OFFSET] == 0.03


def test_an_effect_found_later_was_not_told_of_before():
    memory = MachineMemory(MotorParameters())
    memory.learn(20.0, told(spread=1e-9))
    memory.has_evidence(evidence_of("voltage_offset", 9.0), told())
    assert spread_of(memory.before(25.0, 25.0), OFFSET) == pytest.approx(EFFECT_SPREAD[1])


def test_what_was_told_makes_nothing_less_sure_than_nothing_told():
    memory = MachineMemory(MotorParameters())
    memory.has_evidence(evidence_of("voltage_offset", 9.0), told())
    first = memory.before(0.0, 0.0).covariance
    memory.learn(20.0, told(spread=10.0))
    assert (np.diag(memory.before(1e6, 1e6).covariance) <= np.diag(first) * (1 + 1e-12)).all()


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


def test_a_memory_that_was_kept_goes_on_as_if_it_had_never_ended():
    first = MachineMemory(MotorParameters())
    assert first.recollection() is None
    first.has_evidence(evidence_of("voltage_offset", 20.0), told())
    first.has_cogging(12)
    first.voltage_offset(told(offset=0.02))
    first.learn(10.0, told(offset=0.02))
    later = MachineMemory(MotorParameters())
    later.recall(first.recollection(), 25.0)
    for one, other in zip(first.before(35.0, 35.0), later.before(7.0, 7.0), strict=True):
        np.testing.assert_array_equal(one, other)
    assert later.cogs == 12
    assert later.voltage_offset(told(offset=1e-4)) is not None, "it is told from none already"
    assert not later.has_evidence(evidence_of("voltage_offset", 20.0), told())


def test_the_older_what_was_kept_the_less_is_known():
    first = MachineMemory(MotorParameters(coulomb_friction=0.01))
    first.learn(10.0, told(friction=0.1))
    kept = first.recollection()
    spreads = []
    for age in (1.0, 1e3, 1e6):
        later = MachineMemory(MotorParameters(coulomb_friction=0.01))
        later.recall(kept, age)
        spreads.append(spread_of(later.before(0.0, 0.0), FRICTION))
    assert spreads == sorted(spreads)
    assert spreads[0] < spreads[-1] == pytest.approx(EFFECT_SPREAD[0]), "no less than at first"


def test_a_machine_that_is_another_one_is_known_by_its_model_alone():
    memory = MachineMemory(MotorParameters())
    memory.has_evidence(evidence_of("drift", 9.0), told())
    memory.learn(20.0, told(0.02, spread=1e-9))
    delay = EFFECTS.index("delay")
    memory.begin_anew(24, {delay})
    assert memory.cogs == 24
    assert {EFFECTS[place] for place in memory.present} == {
        "delay",
        "cogging_sine",
        "cogging_cosine",
    }
    known = memory.before(30.0, 30.0)
    assert not known.expected[len(FACTORS) :].any()
    assert spread_of(known, len(FACTORS) + delay) == pytest.approx(EFFECT_SPREAD[delay])
    assert memory.recollection() is None
