"""Ways to decide on the dead zone: all stable, the simulated ones less conservative."""

import pytest

from bdt_study.engine.in_this_process import InThisProcess
from bdt_study.reproduction.decision_sweep import (
    EQUATION_9,
    ORACLE,
    REDESIGNED,
    SIMULATED,
    DecisionOutcome,
    decision_figure,
    decisions_are_not_conservative,
    decisions_are_stable,
    sweep_decisions,
)
from bdt_study.reproduction.experiments import Choices


@pytest.fixture(scope="module")
def outcomes():
    return sweep_decisions(InThisProcess(), Choices(), (20.0,))


def test_every_way_is_tried(outcomes):
    assert [each.way for each in outcomes] == [EQUATION_9, SIMULATED, REDESIGNED, ORACLE]


def test_decisions_by_simulation_are_stable_and_redesigned_gains_have_the_least_bias(outcomes):
    assert decisions_are_stable(outcomes).holds
    biases = {each.way: each.bias for each in outcomes}
    assert min(biases, key=biases.__getitem__) == REDESIGNED
    assert all(each.bias <= 1.01 * each.width for each in outcomes)
    by_way = {each.way: each for each in outcomes}
    assert by_way[REDESIGNED].settling <= 1.2 * by_way[EQUATION_9].settling
    assert by_way[ORACLE].limit_cycles == 0
    # Eq. 9: p theta_b over 5 mm.
    assert by_way[EQUATION_9].width == pytest.approx(100.0 * 1e-3 * 20.0 / 360.0 / 5e-3)
    assert by_way[REDESIGNED].width < 0.7 * by_way[EQUATION_9].width


def outcome(way, bias=0.5, limit_cycles=0):
    return DecisionOutcome(way, 28.0, bias, 2.0, limit_cycles, 1.5)


def test_a_limit_cycle_or_much_bias_makes_the_claims_fail():
    ways = (EQUATION_9, SIMULATED, REDESIGNED, ORACLE)
    assert decisions_are_not_conservative([outcome(way) for way in ways]).holds
    assert not decisions_are_not_conservative([outcome(way, bias=1.0) for way in ways]).holds
    cycling = [outcome(way, limit_cycles=way == SIMULATED) for way in ways]
    assert not decisions_are_stable(cycling).holds
    only_by_rule = [outcome(way, limit_cycles=way == EQUATION_9) for way in ways]
    assert decisions_are_stable(only_by_rule).holds


def test_the_figure_has_bias_and_settling(outcomes):
    assert len(decision_figure(outcomes).axes) == 2
