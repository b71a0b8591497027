"""Closed-loop runs with estimators: what is judged, and that estimators differ as they should."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bdt_analysis.metrics.reference_steps import find_steps
from bdt_plant.actuator import ActuatorParameters
from bdt_plant.gap_profile import GapProfile
from bdt_plant.pushes import PushParameters
from bdt_study.evaluation import cases, trial
from bdt_study.evaluation.cases import CASES, draw_scenario
from bdt_study.evaluation.machine_effects import MachineEffects
from bdt_study.evaluation.trial import (
    avoidable_limit_cycles,
    by_pushes,
    error_of,
    evaluate_loop,
    is_pushed_while_judged,
    judged_steps,
    run_trial,
    steps_with_true_gap,
)
from bdt_study.simulation.closed_loop import Trajectory, simulate
from bdt_study.simulation.twin_loop import TwinTrajectory
from bdt_twin.decision import Decision
from bdt_twin.estimator import Estimate
from bdt_twin.simulated_decision import SimulatedDecision

BY_NAME = {case.name: case for case in CASES}


@pytest.fixture
def short(monkeypatch):
    monkeypatch.setattr(cases, "DURATION", 25.0)


def test_the_estimator_for_measured_signals_copes_where_the_paper_s_fails(short):
    fitted = run_trial(BY_NAME["laboratory"], "output_error", 1)
    assert fitted.errors.size >= 10
    assert np.rad2deg(np.sqrt(np.mean(fitted.errors**2))) < 0.3
    assert np.isfinite(fitted.uncertainties).all()
    assert len(fitted.window_times) >= len(fitted.errors)
    paper = run_trial(BY_NAME["laboratory"], "inverse_filter", 1)
    assert np.rad2deg(np.abs(paper.errors).max()) > 10.0
    assert np.isnan(paper.uncertainties).all()


def test_decisions_are_made_with_what_the_estimator_knows(monkeypatch):
    monkeypatch.setattr(cases, "DURATION", 14.0)
    known = []

    def deciding(_self, _estimate, machine, _now, _delay, noise):
        known.append((machine, noise))
        return Decision(None, None, "")

    monkeypatch.setattr(SimulatedDecision, "decide", deciding)
    harsh = BY_NAME["harsh"]
    run_trial(harsh, "output_error", 1, "simulate")
    machine, noise = known[-1]
    assert machine.covariance.any()
    assert noise == pytest.approx(harsh.reading_error, rel=0.2)


def test_the_paper_s_estimator_is_right_on_clean_signals(short):
    clean = run_trial(replace(BY_NAME["clean"], gap="constant"), "inverse_filter", 2)
    assert clean.errors.size > 20
    assert np.rad2deg(np.sqrt(np.mean(clean.errors**2))) < 0.15


def test_bounds_are_there_where_the_model_is_exact_and_there_is_noise(monkeypatch):
    monkeypatch.setattr(cases, "DURATION", 14.0)
    monkeypatch.setattr(trial, "BOUND_EVERY", 3)
    exact = run_trial(BY_NAME["exact_model"], "output_error", 1)
    assert exact.bounds.size == exact.bound_errors.size > 0
    assert exact.bounds.min() > 0.0
    assert run_trial(BY_NAME["clean"], "output_error", 1).bounds.size == 0


def test_the_error_is_that_of_the_time_for_which_the_gap_is_stated():
    growing = GapProfile(kind="ramp", final=1.0, growth_time=10.0)
    assert error_of(Estimate(5.0, 0.6), growing) == pytest.approx(0.1)
    assert error_of(Estimate(5.0, 0.6), growing, 2.0) == pytest.approx(0.3)


def run_with(dead_zones, duration=24.0):
    """Return a loop with a gap of 25 degrees and the dead zones of each control period."""
    scenario = replace(
        draw_scenario(BY_NAME["clean"], 0),
        duration=duration,
        gap=GapProfile(kind="constant", initial=math.radians(25.0)),
    )
    scenario = replace(scenario, reference=replace(scenario.reference, first=5e-3, step_time=8.0))
    tolerances = np.asarray(dead_zones(np.arange(scenario.control_steps) / 500.0))
    loop = simulate(replace(scenario, dead_zone=tolerances))
    assert isinstance(loop, Trajectory)
    return scenario, TwinTrajectory(loop, tolerances, (), np.zeros_like(tolerances))


def judge(scenario, run):
    return evaluate_loop(judged_steps(scenario, run.loop, run.tolerances))


def judged(dead_zones):
    return judge(*run_with(dead_zones))


def test_a_loop_that_never_gets_a_dead_zone_is_judged_whole():
    limit_cycles, _ = judged(lambda t: 0.0 * t)
    assert limit_cycles == 3


def test_steps_before_the_first_dead_zone_do_not_count():
    wide = 1.15 * math.radians(25.0) * 1e-3 / (2 * math.pi)
    limit_cycles, worst_bias = judged(lambda t: np.where(t < 7.0, 0.0, wide))
    assert limit_cycles == 0
    assert 0.0 < worst_bias < 2.0


def judge_beside_the_true_gap(scenario, run):
    return avoidable_limit_cycles(
        judged_steps(scenario, run.loop, run.tolerances),
        steps_with_true_gap(scenario, scenario.gap, run.tolerances),
    )


def avoidable(dead_zones):
    return judge_beside_the_true_gap(*run_with(dead_zones))


def test_a_loop_without_a_dead_zone_has_limit_cycles_that_knowing_the_gap_avoids():
    assert avoidable(lambda t: 0.0 * t) == (3, 3)


def test_steps_before_the_first_dead_zone_are_nobody_s_fault():
    wide = 1.15 * math.radians(25.0) * 1e-3 / (2 * math.pi)
    assert avoidable(lambda t: np.where(t < 7.0, 0.0, wide)) == (0, 2)


def test_an_offset_of_the_amplifier_is_no_fault_of_the_estimator():
    """It makes the motor creep in the dead zone, with the true gap as well."""
    scenario, run = run_with(lambda t: 0.0 * t)
    scenario = replace(scenario, actuator=ActuatorParameters(offset=0.05))
    run = replace(run, loop=simulate(scenario))
    assert judge(scenario, run)[0] == 3
    _, steps_without = judge_beside_the_true_gap(scenario, run)
    assert steps_without <= 1


def test_steps_that_something_pushes_while_they_are_judged_are_counted_apart():
    """Pushes at 6.5, 13 and 19.5 s; steps of 8 s are judged by their last 3 s."""
    scenario, run = run_with(lambda t: 0.0 * t)
    pushes = PushParameters(force=1.0, period=6.5)
    scenario = replace(scenario, model=replace(scenario.model, pushes=pushes))
    steps = judged_steps(scenario, run.loop, run.tolerances)
    assert [step.limit_cycle for step in steps] == [True] * 3
    ideal = [replace(step, limit_cycle=step is steps[1]) for step in steps]
    assert by_pushes(scenario, steps) == (steps[2:], steps[:2])
    assert by_pushes(scenario, ideal) == (ideal[2:], ideal[:2])
    assert [evaluate_loop(each[:2])[0] for each in (steps, ideal)] == [2, 1]


def test_a_trial_tells_of_pushed_steps_in_nothing_else(short, monkeypatch):
    calm = run_trial(BY_NAME["laboratory"], "inverse_filter", 1)
    monkeypatch.setattr(trial, "is_pushed_while_judged", lambda *_: True)
    pushed = run_trial(BY_NAME["laboratory"], "inverse_filter", 1)
    steps, with_true_gap = calm.settling_times.size, calm.settling_times.size - calm.avoidable_steps
    assert calm.limit_cycles > 0
    assert (calm.pushed_steps, calm.pushed_limit_cycles, calm.pushed_with_true_gap) == (0, 0, 0)
    assert pushed.pushed_steps == steps
    assert pushed.pushed_limit_cycles == calm.limit_cycles
    assert pushed.pushed_with_true_gap == with_true_gap
    assert pushed.settling_times.size == pushed.avoidable_steps == 0
    assert pushed.limit_cycles == pushed.avoidable_limit_cycles == pushed.worst_bias == 0


def test_without_pushes_all_steps_count():
    scenario, run = run_with(lambda t: 0.0 * t)
    steps = judged_steps(scenario, run.loop, run.tolerances)
    assert by_pushes(scenario, steps) == (steps, [])


@pytest.mark.parametrize("length", [4.0, 5.0, 8.0, 12.0])
def test_a_step_is_pushed_where_the_analysis_looks_at_it(length):
    times = np.arange(0.0, 3.0 * length, 0.01)
    levels = np.array([(0.0, 5e-3), (length, 0.0), (2.0 * length, 5e-3)])
    telemetry = np.column_stack([times, 0.0 * times, 0.0 * times])
    for step in find_steps(levels, telemetry, 0.01):
        for period in np.arange(1.03, 40.0, 0.37):
            begun = period * np.arange(1.0, 40.0)
            expected = bool(((begun >= step.t_end - step.window) & (begun < step.t_end)).any())
            pushes = PushParameters(force=1.0, period=float(period))
            assert is_pushed_while_judged(step.t_start, length, pushes) is expected


def test_a_push_at_the_end_of_a_step_looks_like_a_limit_cycle():
    """That is why: the loop comes to rest before it, and has none without it."""
    wide = 1.15 * math.radians(25.0) * 1e-3 / (2 * math.pi)
    scenario, run = run_with(lambda t: 0.0 * t + wide)
    assert judge(scenario, run)[0] == 0
    pushed = replace(scenario.model, pushes=PushParameters(force=1.0, period=7.0))
    scenario = replace(scenario, model=pushed, dead_zone=run.tolerances)
    loop = simulate(scenario)
    assert judge(scenario, replace(run, loop=loop))[0] > 0


def test_friction_that_nobody_told_of_is_found(short):
    effects = MachineEffects(least=1.0, friction=0.02)
    rubbing = run_trial(replace(BY_NAME["friction"], effects=effects), "output_error", 1)
    assert rubbing.errors.size >= 10
    assert np.rad2deg(np.abs(rubbing.errors)).max() < 0.5


def test_the_margin_is_part_of_what_is_commanded(monkeypatch):
    class EnoughError(Exception):
        """The dead zone is known, and what becomes of the loop does not matter."""

    sent = []

    def noting(scenario, estimator, link, dead_zone, **_options):
        sent.append(dead_zone)
        raise EnoughError

    monkeypatch.setattr(trial, "simulate_with_twin", noting)
    for kind in ("output_error", "inverse_filter"):
        with pytest.raises(EnoughError):
            run_trial(BY_NAME["clean"], kind, 0)
    assert sent == [trial.MARGIN, trial.EQUATION_9]
