"""The closed loop offline with the digital twin in it: estimator, slow link, reconfiguration.

The compiled loop runs from one batch of telemetry to the next. Whatever the twin sends arrives
after the batch behind it, so the dead zone of the next interval is known before it is computed.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from bdt_controller.control_law import discretize_control, switched
from bdt_plant.plant import PlantModel
from bdt_study.simulation.closed_loop import (
    SIGNALS,
    Scenario,
    Trajectory,
    discrete_loop,
    initial_state,
    sample_inputs,
    signals_for,
    trajectory_of,
)
from bdt_study.simulation.loop_kernel import SIMULATED, allocate, run_kernel
from bdt_study.simulation.loop_model import DiscreteLoop, LoopInputs, LoopState
from bdt_study.simulation.offline_twin import OfflineTwin
from bdt_twin.dead_zone_tolerance import EQUATION_9, DeadZoneRule, DeadZoneSettings
from bdt_twin.decider import create_decider
from bdt_twin.decision import ControllerGains, Decision
from bdt_twin.decision_settings import DecisionSettings
from bdt_twin.estimator import Estimate, Estimator
from bdt_twin.inverse_filter import InverseFilterEstimator, InverseFilterSettings
from bdt_twin.link import PAPER_LINK, DelayedLink, LinkSettings
from bdt_twin.reconfiguration import Reconfigurator

FloatArray = NDArray[np.float64]

DECIDED_BY_RULE = DecisionSettings()
"""No simulated decisions."""


@dataclass(frozen=True, eq=False)
class TwinTrajectory:
    """What a simulation with the twin gives.

    Attributes
    ----------
    loop : Trajectory
        Signals of the loop.
    tolerances : ndarray, shape (control steps,)
        Dead-zone tolerance epsilon_dz in force at each measurement [m].
    estimates : tuple of Estimate
        What the estimator said.
    voltage_offsets : ndarray, shape (control steps,)
        Voltage that the controller adds to its command at each measurement [V].
    decisions : tuple of Decision
        What was decided by simulation, for each estimate that is known; empty for eq. 9.
    """

    loop: Trajectory
    tolerances: FloatArray
    estimates: tuple[Estimate, ...]
    voltage_offsets: FloatArray
    decisions: tuple[Decision, ...] = ()

    @property
    def estimate_times(self) -> FloatArray:
        """Times for which the gap is stated [s], shape (m,)."""
        return np.array([estimate.time for estimate in self.estimates])

    @property
    def estimated_gaps(self) -> FloatArray:
        """Estimated gaps theta_b [rad], shape (m,)."""
        return np.array([estimate.gap for estimate in self.estimates])


def simulate_with_twin(
    scenario: Scenario,
    estimator: Estimator | None = None,
    link: LinkSettings = PAPER_LINK,
    dead_zone: DeadZoneSettings = EQUATION_9,
    telemetry_period: float = 0.1,
    keep: Sequence[str] = SIGNALS,
    *,
    compensate_offset: bool = True,
    decision: DecisionSettings = DECIDED_BY_RULE,
    believed: PlantModel | None = None,
    redesign: ControllerGains | None = None,
) -> TwinTrajectory:
    """Simulate the reconfigurable controller (figures 5 and 7).

    Parameters
    ----------
    scenario : Scenario
        The loop; its dead zone holds until the first reconfiguration arrives, and so does its
        voltage offset.
    estimator : Estimator, optional
        Fresh estimator; None for the paper's, with the scenario's model and sampling rate.
    link : LinkSettings
        Delays and losses on the way to the controller; 1 s by default.
    dead_zone : DeadZoneSettings
        Width for an estimate; eq. 9 by default.
    telemetry_period : float
        Time covered by one batch of telemetry [s], rounded to whole control periods.
    keep : sequence of str
        Signals of the loop to keep, out of ``SIGNALS``; u and measured are always kept.
    compensate_offset : bool
        Whether the controller is to be set against an offset of the amplifier that the estimator
        knows.
    decision : DecisionSettings
        How dead zone and gains are decided on; by the rule of `dead_zone` by default.
    believed : PlantModel, optional
        The mechanism as the twin knows it, for eq. 9 and decisions; the scenario's by default.
    redesign : ControllerGains, optional
        Gains that a simulated decision may set, if its settings say so.

    Returns
    -------
    TwinTrajectory
        Loop, dead zone, voltage offset and estimates.
    """
    sampling = scenario.sampling
    rate, hold = sampling.sampling_rate, sampling.samples_per_control_step
    keep = (*keep, "u", "measured")
    inputs, signals = sample_inputs(scenario), signals_for(scenario, keep)
    u, measured = (signals[SIMULATED.index(name)] for name in ("u", "measured"))
    step, state = discrete_loop(scenario), initial_state(scenario, inputs)
    if estimator is None:
        settings = InverseFilterSettings(sampling_rate=rate)
        estimator = InverseFilterEstimator(scenario.model, settings)
    believed = scenario.model if believed is None else believed
    rule = DeadZoneRule(dead_zone, believed.lead_screw.pitch)
    delayed, gains = DelayedLink(link), ControllerGains(scenario.gains, scenario.notch)
    decider = create_decider(
        decision,
        believed,
        gains,
        redesign or gains,
        estimator,
        delayed.expected_delay,
        dead_zone.horizon,
    )
    twin = OfflineTwin(estimator, Reconfigurator(rule, delayed), decider, compensate_offset)

    tolerances, offsets = inputs.tolerances.copy(), inputs.offsets.copy()
    stamps = np.rint(np.arange(scenario.control_steps) * hold * 1e9 / rate).astype(np.int64)
    batch = max(round(telemetry_period * sampling.control_rate), 1)
    for first in range(0, scenario.control_steps, batch):
        steps = slice(first, min(first + batch, scenario.control_steps))
        samples = slice(steps.start * hold, steps.stop * hold)
        switches = twin.reconfigure(stamps[steps], tolerances[steps], offsets[steps])
        # Gains change at a measurement: the kernel runs up to it, and goes on with the new ones.
        edges = sorted({steps.start, *(steps.start + place for place in switches), steps.stop})
        for begin, end in pairwise(edges):
            between = inputs.between(begin, end)._replace(
                tolerances=tolerances[begin:end], offsets=offsets[begin:end]
            )
            if begin - steps.start in switches:
                gains = switches[begin - steps.start]
                state, step = _switched(state, step, between.between(0, 1), gains)
            part = slice(begin * hold, end * hold)
            state = run_kernel(state, step, between, tuple(one[part] for one in signals))
        times = np.arange(samples.start, samples.stop) / rate
        twin.take_telemetry(np.column_stack([times, u[samples], measured[samples]]))
    return TwinTrajectory(
        trajectory_of(scenario, inputs, signals, keep),
        tolerances,
        tuple(twin.estimates),
        offsets,
        tuple(twin.decisions),
    )


def _switched(
    state: LoopState, step: DiscreteLoop, between: LoopInputs, gains: ControllerGains
) -> tuple[LoopState, DiscreteLoop]:
    """Return state and models with which the controller goes on with other gains.

    Parameters
    ----------
    state : LoopState
        State at the measurement at which they arrive.
    step : DiscreteLoop
        Models so far.
    between : LoopInputs
        Inputs of the control period that begins with this measurement.
    gains : ControllerGains
        The gains.
    """
    law = discretize_control(gains.pid, step.control.pid.period, gains.notch)
    if law == step.control:
        return state, step
    # What is measured now nobody knows but the kernel: it shows a reading in a trial.
    trial = allocate(between.gaps.size - 1)
    run_kernel(state, step, between, trial)
    reading = float(trial[SIMULATED.index("measured")][0])
    control = switched(state.control, float(between.references[0]) - reading, step.control, law)
    return state._replace(control=control), step._replace(control=law)
