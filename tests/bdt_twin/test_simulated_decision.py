"""Decisions by simulation: narrow where that does, redesigned where that is better, taken back."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bdt_controller.notch import NO_NOTCH
from bdt_controller.pid import PidGains
from bdt_plant.plant import PlantModel
from bdt_twin import simulated_outcome
from bdt_twin.decision import ControllerGains, decision_values, taken_back_because
from bdt_twin.decision_loop import simulate_steps
from bdt_twin.decision_settings import DecisionSettings
from bdt_twin.estimator import Estimate
from bdt_twin.machine_knowledge import EFFECTS, first_knowledge
from bdt_twin.simulated_decision import BETTER, NARROWER, SIMULATED, WIDER, SimulatedDecision

MODEL = PlantModel()
PITCH = MODEL.lead_screw.pitch
TODAY = ControllerGains(PidGains(), NO_NOTCH)
TUNED = ControllerGains(PidGains(6284.7, 12569.0, -868.39, 0.11636), NO_NOTCH)
SLOWER = ControllerGains(PidGains(1000.0, 10000.0, -100.0, 0.074), NO_NOTCH)
ESTIMATE = Estimate(10.0, math.radians(20.0), math.radians(0.1))
PAPER = DecisionSettings(kind="simulate", step_heights=(5e-3,), step_time=10.0)


def decider(gains=TODAY, redesign=None, settings=PAPER):
    return SimulatedDecision(settings, MODEL, gains, redesign)


def decide(one, now=11.0, estimate=ESTIMATE, machine=None):
    return one.decide(estimate, machine, now, 1.0)


def restless(end):
    times = np.arange(0.0, end, 0.01)
    return np.column_stack([times, np.cos(9.0 * times), 1e-3 * np.sin(9.0 * times)])


def test_with_gains_for_the_mechanism_much_less_than_eq_9_does():
    decision = decide(decider(TUNED))
    assert decision.tolerance == pytest.approx(decision.ratio * PITCH * ESTIMATE.gap)
    assert decision.ratio <= 0.6
    assert decision.bias <= 1.01 * decision.tolerance / 5e-3
    assert 0.5 < decision.settling < 5.0
    assert decision.gains is None
    assert "narrowest without a limit cycle" in decision.reason


def test_who_knows_less_of_the_mechanism_decides_on_no_narrower_dead_zone():
    sure = first_knowledge(MODEL.motor).without(range(len(EFFECTS)))
    covariances = (
        np.diag(np.square([*spread, *np.zeros(len(EFFECTS))]))
        for spread in ((1e-3, 1e-3, 1e-3), (0.05, 0.03, 0.2))
    )
    known, unknown = (
        decide(decider(), machine=sure._replace(covariance=covariance))
        for covariance in covariances
    )
    widths = [math.inf if one.tolerance is None else one.tolerance for one in (known, unknown)]
    assert widths[0] <= widths[1]


def test_growth_until_the_next_decision_makes_the_dead_zone_wider():
    growing = ESTIMATE._replace(growth=math.radians(1.0))
    decision = decide(decider(TUNED), estimate=growing)
    ahead = ESTIMATE.gap + math.radians(1.0) * (11.0 + 1.0 - 10.0)
    assert decision.tolerance == pytest.approx(decision.ratio * PITCH * ahead)


def test_between_two_simulations_the_dead_zone_follows_the_gap():
    one = decider(TUNED)
    first = decide(one)
    later = decide(one, 12.0, ESTIMATE._replace(gap=math.radians(25.0)))
    assert later.ratio == first.ratio
    # The decision has to hold until the next one: nothing grows here.
    assert later.tolerance == pytest.approx(1.25 * first.tolerance)


def test_where_no_dead_zone_does_eq_9_stays_and_that_is_said():
    wild = ControllerGains(PidGains(3080.0, 3e5), NO_NOTCH)
    decision = decide(decider(wild))
    assert decision.tolerance is None
    assert "limit cycles with dead zones up to 2 times" in decision.reason


def test_better_gains_are_set_and_worse_ones_are_not():
    better = decide(decider(TODAY, TUNED))
    assert better.gains == TUNED
    assert "redesigned gains" in better.reason
    worse = decide(decider(TUNED, SLOWER))
    assert worse.gains == TUNED
    assert worse.tolerance == decide(decider(TUNED)).tolerance


def test_an_accepted_redesign_is_never_worse_on_the_mechanisms_of_the_twin():
    for gap in (5.0, 10.0, 20.0, 28.0):
        estimate = ESTIMATE._replace(gap=math.radians(gap))
        before, after = (
            decide(decider(), 11.0, estimate),
            decide(decider(TODAY, TUNED), 11.0, estimate),
        )
        if after.gains == TUNED and before.tolerance is not None:
            assert after.tolerance <= before.tolerance
            assert after.bias <= before.bias
            assert after.settling <= BETTER * before.settling


def test_a_loop_that_does_not_rest_as_promised_gets_eq_9_and_its_gains_back():
    one = decider(TODAY, TUNED)
    assert decide(one).gains == TUNED
    one.watch(restless(40.0))
    taken_back = decide(one, 41.0)
    assert (taken_back.tolerance, taken_back.gains, taken_back.taken_back) == (None, TODAY, 1)
    assert "a decision was taken back: the loop has not rested" in taken_back.reason
    assert taken_back.distrust in taken_back.reason
    assert taken_back.distrust
    assert taken_back_because(None, taken_back) == taken_back.reason
    assert taken_back_because(taken_back, taken_back) == ""
    trusted_again = decide(one, 40.0 + PAPER.probation + 1.0)
    assert trusted_again.tolerance is not None
    assert (trusted_again.gains, trusted_again.distrust) == (TODAY, "")
    one.restart()
    assert decide(one).gains == TUNED


def test_a_decision_is_the_same_for_the_same_knowledge():
    assert decide(decider(TODAY, TUNED)) == decide(decider(TODAY, TUNED))


@pytest.mark.parametrize("length", [4.0, 8.0, 12.0, 100.0])
def test_the_work_of_a_decision_is_bounded_however_long_the_steps_are(length, monkeypatch):
    simulated = []

    def counting(member, law, tolerance, limit, references):
        simulated.append(references.size / PAPER.control_rate)
        return simulate_steps(member, law, tolerance, limit, references)

    monkeypatch.setattr(simulated_outcome, "simulate_steps", counting)
    decide(decider(TODAY, TUNED, replace(PAPER, step_time=length)))
    assert max(simulated) <= SIMULATED
    tried = 2 * (len(NARROWER) + len(WIDER))
    assert len(simulated) <= tried * PAPER.members


def test_the_diagnostics_tell_reason_and_expectation():
    values = decision_values(decide(decider(TUNED)))
    assert values["decision"] == "simulate"
    assert 0.0 < values["expected_bias_percent"] < 2.0
    assert values["decisions_taken_back"] == 0
    assert decision_values(None) == {"decision": "equation_9"}


@pytest.mark.parametrize(
    ("fault", "text"),
    [
        ({"kind": "guess"}, "kind = 'guess': must be one of equation_9, simulate"),
        ({"step_heights": ()}, "step_heights = .*: must have at least one height"),
        ({"members": 0}, "members = 0: must be 1 to 100"),
    ],
)
def test_a_fault_of_the_settings_is_named(fault, text):
    with pytest.raises(ValueError, match=text):
        DecisionSettings(**fault)


def test_a_decision_goes_on_with_the_redesign_that_is_in_force():
    gains = dict(TUNED.by_name())
    resumed = decider(redesign=TUNED)
    resumed.resume(gains)
    assert decide(resumed).gains == TUNED
    other = decider(redesign=SLOWER)
    other.resume(gains)
    assert decide(other).gains != TUNED, "these are not its own"
    resumed.restart()
    fresh = decider(redesign=TUNED)
    assert decide(resumed) == decide(fresh), "another run begins"
