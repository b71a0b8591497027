"""The closed loop offline with the digital twin in it: estimator, slow link, reconfiguration.

The compiled loop runs from one batch of telemetry to the next. Whatever the twin sends arrives
after the batch behind it, so the dead zone of the next stretch is known before it is computed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bdt_bringup.simulation.closed_loop import (
    SIGNALS,
    Scenario,
    Trajectory,
    initial_state,
    loop_step,
    sample_inputs,
    signals_for,
    trajectory_of,
)
from bdt_bringup.simulation.loop_kernel import SIMULATED, run_kernel
from bdt_msgs_py.reading import nanoseconds_from_seconds
from bdt_plant.plant import PlantModel
from bdt_twin.dead_zone_width import tolerance_for_gap
from bdt_twin.inverse_filter import InverseFilterEstimator, InverseFilterSettings
from bdt_twin.link import DelayedLink

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TwinTrajectory:
    """What a simulation with the twin gives.

    Attributes
    ----------
    loop : Trajectory
        Signals of the loop.
    tolerances : ndarray, shape (control steps,)
        Dead-zone tolerance epsilon_dz in force at each measurement [m].
    estimate_times : ndarray, shape (m,)
        Times of the estimates: ends of the update periods behind them [s].
    estimates : ndarray, shape (m,)
        Estimated gaps theta_b [rad].
    """

    loop: Trajectory
    tolerances: FloatArray
    estimate_times: FloatArray
    estimates: FloatArray


def simulate_with_twin(
    scenario: Scenario,
    settings: InverseFilterSettings | None = None,
    delay: float | Callable[[], float] = 1.0,
    telemetry_period: float = 0.1,
    keep: Sequence[str] = SIGNALS,
    twin_model: PlantModel | None = None,
) -> TwinTrajectory:
    """Simulate the reconfigurable controller (figures 5 and 7).

    Parameters
    ----------
    scenario : Scenario
        The loop; its dead zone holds until the first reconfiguration arrives.
    settings : InverseFilterSettings, optional
        Settings of the estimator; None for the paper's at the scenario's sampling rate.
    delay : float or callable
        Communication delay [s], or a function without arguments that draws one for each
        reconfiguration.
    telemetry_period : float
        Time covered by one batch of telemetry [s], rounded to whole control periods.
    keep : sequence of str
        Signals of the loop to keep, out of ``SIGNALS``; u and measured are always kept.
    twin_model : PlantModel, optional
        Mechanism in which the twin believes; None for the scenario's own.

    Returns
    -------
    TwinTrajectory
        Loop, dead zone and estimates.
    """
    sampling = scenario.sampling
    rate, hold = sampling.sampling_rate, sampling.samples_per_control_step
    keep = (*keep, "u", "measured")
    inputs, signals = sample_inputs(scenario), signals_for(scenario, keep)
    u, measured = (signals[SIMULATED.index(name)] for name in ("u", "measured"))
    step, state = loop_step(scenario), initial_state(scenario, inputs)
    settings = settings or InverseFilterSettings(sampling_rate=rate)
    twin = _Twin(twin_model or scenario.model, settings, delay)

    tolerances = inputs.tolerances.copy()
    stamps = np.rint(np.arange(scenario.control_steps) * hold * 1e9 / rate).astype(np.int64)
    batch = max(round(telemetry_period * sampling.control_rate), 1)
    for first in range(0, scenario.control_steps, batch):
        steps = slice(first, min(first + batch, scenario.control_steps))
        samples = slice(steps.start * hold, steps.stop * hold)
        twin.set_dead_zones(stamps[steps], tolerances[steps])
        stretch = inputs.stretch(steps.start, steps.stop)._replace(tolerances=tolerances[steps])
        state = run_kernel(state, step, stretch, tuple(signal[samples] for signal in signals))
        twin.take_telemetry((samples.stop - 1) / rate, u[samples], measured[samples])
    return TwinTrajectory(
        trajectory_of(scenario, inputs, signals, keep),
        tolerances,
        np.array(twin.estimate_times),
        np.array(twin.estimates),
    )


class _Twin:
    """Estimator and link, as the twin's node puts them together."""

    def __init__(
        self,
        model: PlantModel,
        settings: InverseFilterSettings,
        delay: float | Callable[[], float],
    ) -> None:
        self._rate = settings.sampling_rate
        self._pitch = model.lead_screw.pitch
        self._estimator = InverseFilterEstimator(model, settings)
        # The delay may differ from message to message, so it is added to the time of sending.
        self._link = DelayedLink(0.0)
        self._delay = delay if callable(delay) else lambda: delay
        self._in_force: float | None = None
        self.estimate_times: list[float] = []
        self.estimates: list[float] = []

    def set_dead_zones(self, stamps: NDArray[np.int64], tolerances: FloatArray) -> None:
        """Set the tolerances in force at the next measurements.

        Parameters
        ----------
        stamps : ndarray, shape (n,)
            Times of the measurements [ns].
        tolerances : ndarray, shape (n,)
            Tolerances without the twin [m]; overwritten from the first reconfiguration on.
        """
        if self._in_force is not None:
            tolerances[:] = self._in_force
        while (due := self._link.next_due()) is not None and due <= stamps[-1]:
            first = int(np.searchsorted(stamps, due))
            arrived = self._link.deliver(int(stamps[first]))
            if arrived is not None:
                self._in_force = arrived.tolerance
                tolerances[first:] = self._in_force

    def take_telemetry(self, newest: float, voltage: FloatArray, position: FloatArray) -> None:
        """Estimate from a batch whose last sample has the time `newest` [s], and send (eq. 9)."""
        estimates = self._estimator.update(voltage, position)
        for estimate in estimates:
            self.estimate_times.append(estimate.sample / self._rate)
            self.estimates.append(estimate.gap)
        if estimates:
            sent = nanoseconds_from_seconds(newest) + round(self._delay() * 1e9)
            stamp = round(estimates[-1].sample * 1e9 / self._rate)
            self._link.send(sent, stamp, tolerance_for_gap(estimates[-1].gap, self._pitch))
