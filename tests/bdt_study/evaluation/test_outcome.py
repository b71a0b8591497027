"""One row of the table, from trials whose numbers are known."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bdt_study.evaluation.outcome import summarize_trials
from bdt_study.evaluation.trial import Trial

NOTHING = np.empty(0)


def trial(
    errors,
    uncertainties,
    *,
    bounds=NOTHING,
    limit_cycles=0,
    worst_bias=0.5,
    times=(0.01,),
    avoidable=(0, 0),
):
    return Trial(
        np.deg2rad(errors),
        np.deg2rad(uncertainties),
        np.deg2rad(bounds),
        np.deg2rad(errors)[: len(bounds)],
        limit_cycles,
        worst_bias,
        np.array(times),
        *avoidable,
    )


def test_errors_are_taken_over_all_runs():
    row = summarize_trials("c", "e", [trial([3.0], [9.0]), trial([-4.0, 0.0], [9.0, 9.0])])
    assert row.rms_error_deg == pytest.approx(math.sqrt(25.0 / 3.0))
    assert row.worst_error_deg == pytest.approx(4.0)
    assert row.runs == 2


def test_an_interval_covers_1_96_uncertainties_on_either_side():
    row = summarize_trials("c", "e", [trial([1.9, -1.9, 2.0, -2.0], [1.0] * 4)])
    assert row.coverage_95 == 50.0


def test_an_estimator_that_states_no_uncertainty_has_no_coverage():
    assert summarize_trials("c", "e", [trial([1.0], [math.nan])]).coverage_95 is None


def test_the_bound_is_compared_with_the_errors_of_its_own_windows():
    row = summarize_trials("c", "e", [trial([3.0, 4.0, 99.0], [1.0] * 3, bounds=[2.5, 2.5])])
    assert row.crb_ratio == pytest.approx(math.sqrt(12.5) / 2.5)
    assert summarize_trials("c", "e", [trial([3.0], [1.0])]).crb_ratio is None


def test_runs_are_counted_by_what_became_of_the_loop():
    trials = [
        trial([0.1], [1.0], limit_cycles=2, worst_bias=1.0),
        trial([0.1], [1.0], worst_bias=2.0),
        trial([0.1], [1.0], worst_bias=1.9),
        trial([0.1], [1.0]),
    ]
    row = summarize_trials("c", "e", trials)
    assert row.limit_cycle_free_percent == 75.0
    assert row.bias_under_2_percent == 75.0


def test_limit_cycles_count_as_avoidable_where_the_true_gap_has_none():
    trials = [
        trial([0.1], [1.0], limit_cycles=3, avoidable=(0, 5)),
        trial([0.1], [1.0], limit_cycles=3, avoidable=(2, 6)),
        trial([0.1], [1.0], avoidable=(0, 9)),
        trial([0.1], [1.0]),
    ]
    row = summarize_trials("c", "e", trials)
    assert row.avoidable_limit_cycle_percent == 25.0
    assert row.avoidable_steps_percent == 10.0


def test_steps_are_spared_a_limit_cycle_that_the_true_gap_does_not_prevent():
    """Of ten steps, four have a limit cycle with the true gap; here one of these, and another."""
    run = trial([0.1], [1.0], limit_cycles=2, avoidable=(1, 6))
    run = replace(run, settling_times=np.full(10, 2.0))
    assert summarize_trials("c", "e", [run, run]).spared_steps_percent == 75.0
    without = replace(run, limit_cycles=0, avoidable_limit_cycles=0, avoidable_steps=10)
    assert summarize_trials("c", "e", [without]).spared_steps_percent is None


def test_without_a_step_that_could_be_spared_there_is_no_share():
    row = summarize_trials("c", "e", [trial([0.1], [1.0], limit_cycles=8)])
    assert row.avoidable_limit_cycle_percent == 0.0
    assert row.avoidable_steps_percent is None


def test_the_processor_time_is_a_median_in_milliseconds():
    assert (
        summarize_trials("c", "e", [trial([0.1], [1.0], times=[0.02, 0.03, 9.0])]).window_ms == 30
    )


def test_without_any_estimate_there_is_no_error():
    row = summarize_trials("c", "e", [trial([], [], times=[])])
    assert (row.rms_error_deg, row.worst_error_deg, row.window_ms) == (None, None, None)


def test_settling_is_the_median_over_all_steps_and_unknown_where_that_does_not_settle():
    slow = replace(trial([0.1], [1.0]), settling_times=np.array([2.0, 3.0, math.inf]), taken_back=1)
    row = summarize_trials("c", "e", [slow, slow], "simulate")
    assert (row.decision, row.settling_s, row.taken_back) == ("simulate", 3.0, 2)
    never = replace(slow, settling_times=np.array([2.0, math.inf, math.inf]))
    assert summarize_trials("c", "e", [never]).settling_s is None


def test_the_bias_is_the_median_of_the_worst_of_each_run():
    trials = [trial([0.1], [1.0], worst_bias=bias) for bias in (0.2, 0.4, 3.0)]
    assert summarize_trials("c", "e", trials).worst_bias_percent == 0.4


def test_steps_that_were_pushed_are_added_up():
    trials = [
        replace(trial([0.1], [1.0]), pushed_steps=4, pushed_limit_cycles=1, pushed_with_true_gap=2),
        replace(trial([0.1], [1.0]), pushed_steps=3, pushed_with_true_gap=1),
    ]
    row = summarize_trials("c", "e", trials)
    assert row.limit_cycle_free_percent == 100.0
    pushed = row.pushed_steps, row.pushed_limit_cycles, row.pushed_limit_cycles_with_true_gap
    assert pushed == (7, 1, 3)
