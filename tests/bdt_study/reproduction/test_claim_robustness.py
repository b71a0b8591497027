"""Other choices: which claims survive."""

import math
from dataclasses import replace

import pytest

from bdt_study.engine.in_this_process import InThisProcess
from bdt_study.reproduction.claim_robustness import open_choices, robustness_figure, sweep_choices
from bdt_study.reproduction.claims import CLAIMS
from bdt_study.reproduction.experiments import Choices

BIAS = [claim.__name__ for claim in CLAIMS].index("bias_is_small")


@pytest.fixture(scope="module")
def robustness_results():
    amplitude = open_choices()[0]
    return sweep_choices(InThisProcess(), [replace(amplitude, values=(0.5, 5.0))])


def test_every_choice_is_tried_as_it_was_made():
    for choice in open_choices():
        closest = min(choice.values, key=lambda value: abs(value - choice.chosen))
        made = choice.apply(closest)
        assert made.amplitude == pytest.approx(Choices().amplitude)
        assert made.gap.final == pytest.approx(Choices().gap.final)
        assert made.gains.integral == pytest.approx(Choices().gains.integral)
        assert made.step_time == pytest.approx(Choices().step_time)
        assert made.window == pytest.approx(Choices().window)


def test_each_value_changes_the_choices():
    for choice in open_choices():
        made = [choice.apply(value) for value in choice.values]
        assert all(made[k] != made[k + 1] for k in range(len(made) - 1))


def test_the_exponent_keeps_the_mean_gap():
    exponent = open_choices()[2]
    for value in exponent.values:
        assert math.degrees(exponent.apply(value).mean_gap) == pytest.approx(10.0, abs=0.02)


def test_a_bias_of_some_micrometers_is_too_much_for_half_a_millimeter(robustness_results):
    assert robustness_results[0].holding(BIAS) == [5.0]


def test_the_figure_has_a_mark_for_each_claim_and_value(robustness_results):
    axes = robustness_figure(robustness_results).axes[0]
    assert len(axes.lines) == 2 * len(CLAIMS)
    crosses = [line for line in axes.lines if line.get_marker() == "x"]
    holding = sum(claim.holds for claims in robustness_results[0].claims for claim in claims)
    assert len(crosses) == 2 * len(CLAIMS) - holding
