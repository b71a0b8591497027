"""One run of a study and what is found in it, computed when it is asked for."""

import math
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from bdt_analysis.metrics.reference_steps import ReferenceStep, find_steps
from bdt_analysis.metrics.step_analysis import StepSummary, summarize_step
from bdt_controller.reference import ReferenceProfile, reference_at
from bdt_plant.gap_profile import GapProfile, gaps_at
from bdt_study.simulation.closed_loop import Scenario, Trajectory
from bdt_twin.estimator import Estimate

FloatArray = NDArray[np.float64]

REFERENCES = ("square", "table")
"""Kinds of references that consist of steps."""


class RunResult:
    """A run.

    Parameters
    ----------
    scenario : Scenario
        The loop.
    telemetry : ndarray, shape (samples, 3)
        Rows of (t [s], u [V], true q3 [m]).
    trajectory : Trajectory
        Signals of the loop.
    tolerances : ndarray, shape (control steps,)
        Dead zone in force at each measurement [m].
    estimates : tuple of Estimate
        What the twin's estimator said; empty without a twin.
    estimate_age : float
        Time by which an estimate lags behind the time that it states [s].

    Attributes
    ----------
    scenario, telemetry, trajectory, tolerances, estimates
        As given.
    """

    def __init__(
        self,
        scenario: Scenario,
        telemetry: FloatArray,
        trajectory: Trajectory,
        tolerances: FloatArray,
        estimates: tuple[Estimate, ...] = (),
        estimate_age: float = 0.0,
    ) -> None:
        self.scenario = scenario
        self.telemetry = telemetry
        self.trajectory = trajectory
        self.tolerances = tolerances
        self.estimates = estimates
        self._age = estimate_age

    @cached_property
    def steps(self) -> tuple[StepSummary, ...]:
        """The steps that are judged: of a loop with a twin those after its first dead zone."""
        scenario = self.scenario
        reference = scenario.reference
        if not isinstance(reference, ReferenceProfile):
            raise TypeError("the reference of a study is a profile")
        rate = scenario.sampling.sampling_rate
        known = 0.0
        if self.estimates:
            set_at = np.flatnonzero(self.tolerances)
            known = float(set_at[0]) / scenario.sampling.control_rate if set_at.size else 0.0
        return tuple(
            summarize_step(step, self.telemetry, 1.0 / rate)
            for step in _steps_of(reference, scenario.samples, rate)
            if step.t_start >= known and not step.cut
        )

    @cached_property
    def errors(self) -> FloatArray:
        """Estimated less true gap [rad] of each estimate from which something was learned."""
        gap = self.scenario.gap
        if not isinstance(gap, GapProfile):
            raise TypeError("the gap of a study has a profile")
        learned = self.learned
        times = np.array([max(estimate.time - self._age, 0.0) for estimate in learned])
        return np.array([estimate.gap for estimate in learned]) - gaps_at(gap, times)

    @cached_property
    def learned(self) -> tuple[Estimate, ...]:
        """The estimates from which something was learned."""
        return tuple(each for each in self.estimates if each.is_known and not each.reason)


# The same for all runs of a study but those that vary the reference.
@lru_cache(maxsize=64)
def _steps_of(reference: ReferenceProfile, samples: int, rate: float) -> tuple[ReferenceStep, ...]:
    times = np.arange(samples) / rate
    at_rest = np.zeros((samples, 3))
    at_rest[:, 0] = times
    if reference.kind == "table":
        begins = np.array(reference.table_times)
    else:
        count = math.ceil(samples / rate / reference.step_time - 1e-9)
        begins = reference.step_time * np.arange(count)
    rows = np.array([(time, reference_at(reference, time)) for time in begins.tolist()])
    return tuple(find_steps(rows, at_rest, 1.0 / rate))
