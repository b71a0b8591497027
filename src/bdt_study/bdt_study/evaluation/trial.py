"""One closed-loop run with an estimator in it: how far off it was, and what became of the loop."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bdt_analysis.metrics.reference_steps import find_steps, judged_time
from bdt_analysis.metrics.step_analysis import StepSummary, summarize_step
from bdt_controller.reference import ReferenceProfile, reference_at
from bdt_plant.gap_profile import GapProfile, gap_at, gaps_at
from bdt_plant.plant import PlantModel
from bdt_plant.pushes import PushParameters
from bdt_study.design.tuned_gains import TUNED_GAINS
from bdt_study.evaluation.case import Case
from bdt_study.evaluation.cases import draw_scenario
from bdt_study.simulation.closed_loop import Scenario, Trajectory, simulate
from bdt_study.simulation.twin_loop import simulate_with_twin
from bdt_twin.cramer_rao import cramer_rao_bound
from bdt_twin.dead_zone_tolerance import EQUATION_9, DeadZoneSettings
from bdt_twin.decision_settings import DecisionSettings
from bdt_twin.estimator import Estimate, Estimator
from bdt_twin.estimator_choice import EstimatorChoice, create_estimator
from bdt_twin.inverse_filter import InverseFilterSettings
from bdt_twin.next_fit import AcceptedFit, last_fit_of
from bdt_twin.output_error_settings import OutputErrorSettings

FloatArray = NDArray[np.float64]

MARGIN = DeadZoneSettings(coverage_factor=2.0, margin=math.radians(1.0), horizon=1.5)
"""Dead zone of estimators that know how sure they are: that of laboratory.yaml."""

BOUND_EVERY = 10
"""Estimates from one Cramér-Rao bound to the next: a bound costs about as much as an estimate."""


@dataclass(frozen=True, eq=False)
class Trial:
    """What one run gives.

    Steps that something pushes while they are judged tell of a push, not of a limit cycle. They
    are counted apart.

    Attributes
    ----------
    errors : ndarray, shape (n,)
        Estimated less true gap at each estimate from which something was learned [rad].
    uncertainties : ndarray, shape (n,)
        Standard uncertainties that the estimator stated [rad]; NaN where it states none.
    bounds : ndarray, shape (m,)
        Cramér-Rao bounds of the gap's standard deviation [rad], of some windows; empty where the
        model is not exact or nothing is known of the window behind an estimate.
    bound_errors : ndarray, shape (m,)
        Errors of the estimates from these windows [rad].
    limit_cycles : int
        Number of steps that end in a limit cycle.
    worst_bias : float
        Largest bias of all steps [% of the amplitude].
    window_times : ndarray, shape (n,)
        Processor time of each estimate [s].
    avoidable_limit_cycles : int
        Number of steps that end in a limit cycle and would not with the true gap as dead zone.
    avoidable_steps : int
        Number of steps that do not end in a limit cycle with the true gap as dead zone.
    settling_times : ndarray, shape (steps,)
        Settling time of each step [s]; infinite for one that does not settle.
    taken_back : int
        Number of simulated decisions that were taken back.
    pushed_steps : int
        Number of steps that something pushes while they are judged.
    pushed_limit_cycles, pushed_with_true_gap : int
        How many of them are taken for a limit cycle, and how many with the true gap as dead zone.
    """

    errors: FloatArray
    uncertainties: FloatArray
    bounds: FloatArray
    bound_errors: FloatArray
    limit_cycles: int
    worst_bias: float
    window_times: FloatArray
    avoidable_limit_cycles: int = 0
    avoidable_steps: int = 0
    settling_times: FloatArray = field(default_factory=lambda: np.empty(0))
    taken_back: int = 0
    pushed_steps: int = 0
    pushed_limit_cycles: int = 0
    pushed_with_true_gap: int = 0


class InstrumentedEstimator:
    """An estimator with its processor time and, where there is one, its Cramér-Rao bound.

    Parameters
    ----------
    estimator : Estimator
        The estimator.
    noise : float
        Standard deviation of what a reading is off [m]; 0 for no bounds.
    """

    def __init__(self, estimator: Estimator, noise: float) -> None:
        self._estimator = estimator
        self._noise = noise
        self.times: list[float] = []
        self.bounds: list[tuple[Estimate, float]] = []

    @property
    def last_fit(self) -> AcceptedFit | None:
        """What the estimator knows of the mechanism; None from one that does not look at it."""
        return last_fit_of(self._estimator)

    def restart(self) -> None:
        """Forget everything; see :class:`bdt_twin.estimator.Estimator`."""
        self._estimator.restart()

    def update(self, batch: FloatArray, *, newest_only: bool = False) -> Estimate | None:
        """Take the next batch; see :class:`bdt_twin.estimator.Estimator`."""
        began = time.thread_time()
        estimate = self._estimator.update(batch, newest_only=newest_only)
        if estimate is not None:
            self.times.append(time.thread_time() - began)
            if self._noise and not estimate.reason and len(self.times) % BOUND_EVERY == 0:
                self._note_bound(estimate)
        return estimate

    def _note_bound(self, estimate: Estimate) -> None:
        last_fit = self.last_fit
        if last_fit is not None:
            unknowns = last_fit.fit.unknowns
            bound = cramer_rao_bound(last_fit.window, unknowns, estimate.time, self._noise)
            if math.isfinite(bound):
                self.bounds.append((estimate, bound))


def run_trial(case: Case, kind: str, seed: int, decision: str = "") -> Trial:
    """Run one random scenario in closed loop.

    Parameters
    ----------
    case : Case
        The conditions.
    kind : str
        The estimator, as in the twin's parameter ``estimator.kind``.
    seed : int
        Number of the scenario.
    decision : str
        How the twin decides, as in its parameter ``decision.kind``; empty for what the case has.
        One that simulates may set the gains that ``bdt tune`` recommends.
    """
    scenario = draw_scenario(case, seed)
    gap = scenario.gap
    if not isinstance(gap, GapProfile):
        raise TypeError("the gap of a trial has a profile")
    settings = InverseFilterSettings(sampling_rate=case.sampling_rate)
    estimator = InstrumentedEstimator(
        create_estimator(EstimatorChoice(kind), PlantModel(), settings, OutputErrorSettings()),
        case.reading_error if case.is_exact else 0.0,
    )
    dead_zone = EQUATION_9 if kind == "inverse_filter" else MARGIN
    run = simulate_with_twin(
        scenario,
        estimator,
        case.link,
        dead_zone,
        keep=("q3",),
        decision=DecisionSettings(
            kind=decision or case.decision, reconfigure_gains=True, voltage_limit=case.voltage_limit
        ),
        believed=PlantModel(),
        redesign=TUNED_GAINS,
    )
    # What the paper's estimator states is a mean over its window (figure 6).
    age = 0.5 * settings.window if kind == "inverse_filter" else 0.0
    learned = [each for each in run.estimates if each.is_known and not each.reason]
    judged, pushed = by_pushes(scenario, judged_steps(scenario, run.loop, run.tolerances))
    ideal, pushed_ideal = by_pushes(scenario, steps_with_true_gap(scenario, gap, run.tolerances))
    limit_cycles, worst_bias = evaluate_loop(judged)
    avoidable, steps = avoidable_limit_cycles(judged, ideal)
    return Trial(
        np.array([error_of(estimate, gap, age) for estimate in learned]),
        np.array([estimate.uncertainty for estimate in learned]),
        np.array([bound for _, bound in estimator.bounds]),
        np.array([error_of(estimate, gap) for estimate, _ in estimator.bounds]),
        limit_cycles,
        worst_bias,
        np.array(estimator.times),
        avoidable,
        steps,
        np.array(
            [math.inf if one.settling_time_s is None else one.settling_time_s for one in judged]
        ),
        run.decisions[-1].taken_back if run.decisions else 0,
        len(pushed),
        evaluate_loop(pushed)[0],
        evaluate_loop(pushed_ideal)[0],
    )


def error_of(estimate: Estimate, gap: GapProfile, age: float = 0.0) -> float:
    """Return estimated less true gap [rad], `age` [s] before the time of the estimate."""
    return estimate.gap - gap_at(gap, max(estimate.time - age, 0.0))


def evaluate_loop(steps: Sequence[StepSummary]) -> tuple[int, float]:
    """Return the number of limit cycles in some steps and the worst bias [% of the amplitude]."""
    biases = [
        abs(step.bias_percent_of_amplitude)
        for step in steps
        if step.bias_percent_of_amplitude is not None
    ]
    return sum(bool(step.limit_cycle) for step in steps), max(biases, default=0.0)


def avoidable_limit_cycles(
    steps: Sequence[StepSummary], ideal: Sequence[StepSummary]
) -> tuple[int, int]:
    """Return what knowing the gap would have spared.

    Parameters
    ----------
    steps : sequence of StepSummary
        The steps of a loop.
    ideal : sequence of StepSummary
        The same steps with the true gap as dead zone, from :func:`steps_with_true_gap`.

    Returns
    -------
    limit_cycles : int
        Steps with a limit cycle that have none with the true gap.
    steps : int
        Steps that have none with the true gap.
    """
    pairs = zip(steps, ideal, strict=True)
    avoidable = [bool(step.limit_cycle) for step, best in pairs if not best.limit_cycle]
    return sum(avoidable), len(avoidable)


def steps_with_true_gap(
    scenario: Scenario, gap: GapProfile, tolerances: FloatArray
) -> list[StepSummary]:
    """Return the judged steps of a scenario with eq. 9 for the true gap of each instant.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    gap : GapProfile
        Its gap.
    tolerances : ndarray, shape (control steps,)
        Dead zones of the loop that is judged beside it: the same steps count [m].
    """
    times = np.arange(scenario.control_steps) / scenario.sampling.control_rate
    known = scenario.model.lead_screw.pitch * gaps_at(gap, times)
    loop = simulate(replace(scenario, dead_zone=known), ("u", "q3"))
    return judged_steps(scenario, loop, tolerances)


def by_pushes(
    scenario: Scenario, steps: Sequence[StepSummary]
) -> tuple[list[StepSummary], list[StepSummary]]:
    """Return the steps that nothing pushes while they are judged, and those that something does.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    steps : sequence of StepSummary
        Its judged steps.
    """
    length, pushes = _square_wave(scenario).step_time, scenario.model.pushes
    calm: list[StepSummary] = []
    pushed: list[StepSummary] = []
    for step in steps:
        is_pushed = is_pushed_while_judged(step.t_start_s, length, pushes)
        (pushed if is_pushed else calm).append(step)
    return calm, pushed


def is_pushed_while_judged(begin: float, length: float, pushes: PushParameters) -> bool:
    """Tell whether something pushes a platform in the end of a step on which it is judged.

    Parameters
    ----------
    begin, length : float
        Beginning and length of the step [s].
    pushes : PushParameters
        The pushes.
    """
    end = begin + length
    return pushes.fall_between(end - judged_time(length), end)


def judged_steps(scenario: Scenario, loop: Trajectory, tolerances: FloatArray) -> list[StepSummary]:
    """Return the steps that begin after the first of the dead zones in force.

    Judged is the true position, from the first step on that begins after the first dead zone
    has arrived: before a reversal nobody can know the gap. A step that is cut short is left out.
    """
    sample_time = 1.0 / scenario.sampling.sampling_rate
    telemetry = np.stack([loop.t, loop.u, loop.q3], axis=1)
    steps = find_steps(_reference_steps(scenario), telemetry, sample_time)
    set_at = np.flatnonzero(tolerances)
    known = float(set_at[0]) / scenario.sampling.control_rate if set_at.size else 0.0
    judged = [step for step in steps if step.t_start >= known]
    return [summarize_step(step, telemetry, sample_time) for step in judged]


def _reference_steps(scenario: Scenario) -> FloatArray:
    """Return rows of (time [s], r [m]) of the square wave."""
    reference = _square_wave(scenario)
    times = np.arange(0.0, scenario.duration, reference.step_time)
    return np.array([(time, reference_at(reference, float(time))) for time in times])


def _square_wave(scenario: Scenario) -> ReferenceProfile:
    reference = scenario.reference
    if not isinstance(reference, ReferenceProfile):
        raise TypeError("the reference of a trial is a square wave")
    return reference
