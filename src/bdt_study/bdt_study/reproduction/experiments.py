"""The simulations behind figures 3, 4, 6 and 7, and what is found in each."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bdt_analysis.metrics.reference_steps import ReferenceStep, find_steps
from bdt_analysis.metrics.step_analysis import StepSummary, summarize_step
from bdt_bags.run_signals import RunSignals
from bdt_controller.pid import PidGains
from bdt_controller.reference import ReferenceProfile, reference_at
from bdt_plant.gap_profile import GapProfile, gap_at, gaps_at
from bdt_plant.plant import PlantModel
from bdt_study.simulation.closed_loop import Scenario, Trajectory, simulate
from bdt_study.simulation.twin_loop import DECIDED_BY_RULE, simulate_with_twin
from bdt_twin.dead_zone_tolerance import tolerance_for_gap
from bdt_twin.decision import ControllerGains
from bdt_twin.decision_settings import DecisionSettings
from bdt_twin.inverse_filter import InverseFilterEstimator, InverseFilterSettings
from bdt_twin.link import PAPER_LINK, LinkSettings

FloatArray = NDArray[np.float64]

OVER_CONSERVATIVE = 3.0
"""Width of the over-conservative dead zone, as a multiple of the mean gap."""

KEPT = ("u", "theta_m", "theta_d", "q2", "q3")
"""Signals of the loop that figures and claims look at."""


@dataclass(frozen=True)
class Choices:
    """What the paper leaves open; the defaults are those of the package.

    Attributes
    ----------
    amplitude : float
        Height of the steps of the reference [m].
    step_time : float
        Length of a step [s].
    gap : GapProfile
        Growth of the gap theta_b. The constant estimate of figure 4 is its mean, as in the paper.
    gains : PidGains
        Gains of eq. 4.
    window : float
        Length of the data that one estimate averages [s].
    duration : float
        Simulated time [s].
    """

    amplitude: float = ReferenceProfile().first
    step_time: float = ReferenceProfile().step_time
    gap: GapProfile = field(default_factory=GapProfile)
    gains: PidGains = field(default_factory=PidGains)
    window: float = InverseFilterSettings().window
    duration: float = 120.0

    @property
    def reference(self) -> ReferenceProfile:
        """The square wave between zero and the amplitude."""
        return ReferenceProfile(first=self.amplitude, step_time=self.step_time)

    @property
    def mean_gap(self) -> float:
        """Mean of the gap over the run [rad], to 0.01 degree: the constant estimate of figure 4."""
        middles = (np.arange(1200) + 0.5) / 1200 * self.duration
        return math.radians(round(math.degrees(np.mean(gaps_at(self.gap, middles))), 2))

    def scenario(self, dead_zone_gap: float = 0.0) -> Scenario:
        """Return the loop with a constant dead zone for a gap [rad] (eq. 9)."""
        return Scenario(
            duration=self.duration,
            reference=self.reference,
            gap=self.gap,
            dead_zone=tolerance_for_gap(dead_zone_gap, PlantModel().lead_screw.pitch),
            gains=self.gains,
        )

    def settings(self) -> InverseFilterSettings:
        """Return the settings of the estimator."""
        return InverseFilterSettings(window=self.window)


@dataclass(frozen=True, eq=False)
class Experiment:
    """One simulation and what was found in it.

    Attributes
    ----------
    loop : Trajectory
        Signals of the loop.
    signals : RunSignals
        The same as a recording would hold them.
    steps : list of ReferenceStep
        Steps of the reference.
    results : tuple of StepSummary
        Residual, bias, settling time and limit cycle of each.
    gaps : ndarray, shape (steps,)
        True gap at the end of each step [rad].
    """

    loop: Trajectory
    signals: RunSignals
    steps: list[ReferenceStep]
    results: tuple[StepSummary, ...]
    gaps: FloatArray

    @property
    def limit_cycles(self) -> NDArray[np.bool_]:
        """Which steps end in a limit cycle, shape (steps,)."""
        return np.array([bool(step.limit_cycle) for step in self.results])

    @property
    def residuals(self) -> FloatArray:
        """Peak to peak of q3 at the end of each step [m], shape (steps,)."""
        return _numbers([step.residual_peak_to_peak_m for step in self.results])

    @property
    def biases(self) -> FloatArray:
        """Size of the bias of each step [% of the amplitude], shape (steps,)."""
        return np.abs(_numbers([step.bias_percent_of_amplitude for step in self.results]))

    @property
    def settling_times(self) -> FloatArray:
        """Settling time of each step [s], NaN for a step that does not settle, shape (steps,)."""
        return _numbers([step.settling_time_s for step in self.results])


@dataclass(frozen=True, eq=False)
class PaperRuns:
    """The simulations of the paper for one set of choices.

    Attributes
    ----------
    choices : Choices
        What the paper leaves open.
    linear : Experiment
        Linear controller (figure 3).
    fixed : Experiment
        Dead zone for the mean gap (figure 4).
    wide : Experiment
        Dead zone for three times the mean gap.
    reconfigured : Experiment
        Dead zone that the twin sets, with a delay of 1 s (figure 7).
    post_processed : ndarray, shape (k, 2)
        Estimates from the run of figure 4 (figure 6): (middle of the window [s], gap [rad]).
    """

    choices: Choices
    linear: Experiment
    fixed: Experiment
    wide: Experiment
    reconfigured: Experiment
    post_processed: FloatArray


def linear_experiment(choices: Choices) -> Experiment:
    """Run the linear controller (figure 3)."""
    return constant_experiment(choices, 0.0)


def constant_experiment(choices: Choices, dead_zone_gap: float) -> Experiment:
    """Run the controller with a constant dead zone (figure 4).

    Parameters
    ----------
    choices : Choices
        What the paper leaves open.
    dead_zone_gap : float
        Assumed gap of eq. 9 [rad]; zero for no dead zone.
    """
    scenario = choices.scenario(dead_zone_gap)
    dead_zones = np.array([[0.0, scenario.dead_zone]])
    return _experiment(choices, scenario, simulate(scenario, KEPT), dead_zones, np.empty((0, 2)))


def reconfigured_experiment(
    choices: Choices,
    link: LinkSettings = PAPER_LINK,
    decision: DecisionSettings = DECIDED_BY_RULE,
    redesign: ControllerGains | None = None,
) -> Experiment:
    """Run the reconfigurable controller with the digital twin (figure 7).

    Parameters
    ----------
    choices : Choices
        What the paper leaves open.
    link : LinkSettings
        Delays on the way to the controller; 1 s by default.
    decision : DecisionSettings
        How the twin decides; by eq. 9 by default.
    redesign : ControllerGains, optional
        Gains that a decision by simulation may set.
    """
    scenario = choices.scenario()
    estimator = InverseFilterEstimator(scenario.model, choices.settings())
    run = simulate_with_twin(
        scenario, estimator, link, keep=KEPT, decision=decision, redesign=redesign
    )
    changed = np.flatnonzero(np.diff(run.tolerances, prepend=math.nan) != 0)
    dead_zones = np.stack(
        [changed / scenario.sampling.control_rate, run.tolerances[changed]], axis=1
    )
    estimates = np.stack([run.estimate_times, run.estimated_gaps], axis=1)
    return _experiment(choices, scenario, run.loop, dead_zones, estimates)


def run_paper(choices: Choices) -> PaperRuns:
    """Run the simulations of figures 3, 4, 6 and 7, and one with a dead zone far too wide."""
    fixed = constant_experiment(choices, choices.mean_gap)
    return PaperRuns(
        choices,
        linear_experiment(choices),
        fixed,
        constant_experiment(choices, OVER_CONSERVATIVE * choices.mean_gap),
        reconfigured_experiment(choices),
        post_processed_estimates(choices, fixed.loop),
    )


def post_processed_estimates(choices: Choices, loop: Trajectory) -> FloatArray:
    """Estimate the gap from a finished run, as figure 6 does: without delay.

    Parameters
    ----------
    choices : Choices
        What the paper leaves open.
    loop : Trajectory
        A run with u and q3.

    Returns
    -------
    ndarray, shape (k, 2)
        Rows of (middle of the window [s], gap [rad]).
    """
    settings = choices.settings()
    estimator = InverseFilterEstimator(choices.scenario().model, settings)
    estimates = estimator.estimates(loop.u, loop.q3)
    rows = [(e.sample / settings.sampling_rate - 0.5 * settings.window, e.gap) for e in estimates]
    return np.array(rows).reshape(-1, 2)


def _experiment(
    choices: Choices,
    scenario: Scenario,
    loop: Trajectory,
    dead_zones: FloatArray,
    estimates: FloatArray,
) -> Experiment:
    stride = scenario.sampling.samples_per_control_step
    pitch = scenario.model.lead_screw.pitch
    times = loop.t[::stride]
    screw = loop.theta_d[::stride]
    signals = RunSignals(
        telemetry=np.stack([loop.t, loop.u, loop.q3], axis=1),
        truth=np.stack(
            [
                times,
                loop.theta_m[::stride],
                screw,
                gaps_at(choices.gap, times),
                pitch * screw,
                loop.q2[::stride],
                loop.q3[::stride],
            ],
            axis=1,
        ),
        reference=_steps_of(choices),
        estimates=estimates,
        dead_zones=dead_zones,
        pitch=pitch,
    )
    steps = find_steps(signals.reference, signals.telemetry, 1.0 / scenario.sampling.sampling_rate)
    sample_time = 1.0 / scenario.sampling.sampling_rate
    return Experiment(
        loop,
        signals,
        steps,
        tuple(summarize_step(step, signals.telemetry, sample_time) for step in steps),
        np.array([gap_at(choices.gap, step.t_end) for step in steps]),
    )


def _steps_of(choices: Choices) -> FloatArray:
    count = math.ceil(choices.duration / choices.step_time - 1e-9)
    times = [choices.step_time * k for k in range(count)]
    return np.array([(time, reference_at(choices.reference, time)) for time in times])


def _numbers(values: list[float | None]) -> FloatArray:
    return np.array([math.nan if value is None else value for value in values])
