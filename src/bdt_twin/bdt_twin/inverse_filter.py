"""The paper's estimator of the backlash gap (eqs 12, 13 and 14), as a stream."""

from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.quantities import quantity, validate
from bdt_plant.plant import PlantModel
from bdt_twin.angle_observer import AngleObserver
from bdt_twin.contact import NO_CONTACT, ContactSums, compiled_sums, contact_sums, gap_from_sums
from bdt_twin.estimator import Estimate
from bdt_twin.telemetry_stream import TelemetryStream

SAMPLES_AT_A_TIME = 16_384
"""Samples worked on at a time: all arrays on the way then stay in the processor's cache."""


@dataclass(frozen=True)
class InverseFilterSettings:
    """Settings of the paper's estimator; the defaults are the paper's where it gives them."""

    sampling_rate: float = quantity(
        5000.0, "Hz", "sampling rate of the telemetry", minimum=1.0, maximum=1e5
    )
    velocity_threshold: float = quantity(
        0.1,
        "rad/s",
        "speed epsilon_b above which the lead screw counts as moving",
        minimum=0.0,
        maximum=1e6,
    )
    delay: int = quantity(
        2, "samples", "modelling delay N of both filters", minimum=1, maximum=1000
    )
    rounding: float = quantity(
        0.1,
        "deg",
        "scale l of eq. 14: angles are rounded away from zero to multiples of l/2",
        minimum=1e-6,
        maximum=90.0,
    )
    window: float = quantity(
        2.0, "s", "length of the newest data that one estimate averages", minimum=1e-3, maximum=1e4
    )
    update_period: float = quantity(
        0.1, "s", "time between two estimates; divides the window", minimum=1e-3, maximum=1e4
    )

    def __post_init__(self) -> None:
        validate(self)
        blocks = self.window / self.update_period
        if abs(blocks - round(blocks)) > 1e-6 or round(blocks) < 1:
            raise ValueError(
                f"InverseFilterSettings.window = {self.window!r} s: "
                f"must be a multiple of update_period ({self.update_period:g} s)"
            )
        samples = self.update_period * self.sampling_rate
        if abs(samples - round(samples)) > 1e-6 or round(samples) < 1:
            raise ValueError(
                f"InverseFilterSettings.update_period = {self.update_period!r} s: "
                f"must be a whole number of samples at {self.sampling_rate:g} Hz"
            )


class WindowEstimate(NamedTuple):
    """One estimate of the backlash gap.

    Attributes
    ----------
    sample : int
        Samples taken since the last restart when the update period of the estimate ended.
    gap : float
        Estimated gap theta_b [rad].
    forward, backward : int
        Numbers of averaged samples with the screw moving forward and backward.
    """

    sample: int
    gap: float
    forward: int
    backward: int


class InverseFilterEstimator:
    """Streaming estimator: the same estimates for any split of the same data into batches.

    It filters without end, so it starts anew after telemetry that does not continue what was
    before. How sure it is it cannot tell, and it does not look for the growth of the gap.

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism, as the twin knows them.
    settings : InverseFilterSettings
        Settings of the estimator.
    """

    def __init__(self, model: PlantModel, settings: InverseFilterSettings) -> None:
        self._settings = settings
        self._sample_time = 1.0 / settings.sampling_rate
        self._block = round(settings.update_period * settings.sampling_rate)
        self._observer = AngleObserver(model, self._sample_time, settings.delay)
        self._window: deque[ContactSums] = deque(
            maxlen=round(settings.window / settings.update_period)
        )
        # Whatever is not in numba's cache is compiled now, not when the first batch waits.
        compiled_sums()
        self.restart()

    def restart(self) -> None:
        """Forget all samples; the next one has the index zero."""
        self._stream = TelemetryStream(self._settings.sampling_rate)
        self._start()

    def update(
        self,
        batch: NDArray[np.float64],
        *,
        newest_only: bool = False,  # noqa: ARG002
    ) -> Estimate | None:
        """Take the next batch; see :class:`bdt_twin.estimator.Estimator`.

        Parameters
        ----------
        batch : ndarray, shape (n, 3)
            Telemetry rows (t [s], u [V], q3 [m]).
        newest_only : bool
            Makes no difference: a filter has to see all samples.

        Raises
        ------
        TelemetryRejectedError
            For an empty batch, a value that is not finite, a hole, or time that goes back. The
            next batch begins anew.
        """
        if self._stream.accept(batch):
            self._start(float(batch[0, 0]))
        estimates = self.estimates(batch[:, 1], batch[:, 2])
        if not estimates:
            return None
        newest = estimates[-1]
        time = self._first_time + newest.sample / self._settings.sampling_rate
        return Estimate(time, newest.gap)

    def _start(self, first_time: float = 0.0) -> None:
        self._first_time = first_time
        self._observer.restart()
        self._window.clear()
        self._in_window = NO_CONTACT
        self._theta_m = np.empty(0)
        self._theta_d = np.empty(0)
        self._next_sample = 0
        self._to_skip = self._observer.settling

    def estimates(
        self, voltage: NDArray[np.float64], position: NDArray[np.float64]
    ) -> list[WindowEstimate]:
        """Take samples that continue those before and return every estimate that became due.

        Parameters
        ----------
        voltage, position : ndarray, shape (n,)
            Motor voltage u [V] and position q3 of platform 3 [m].

        Returns
        -------
        list of WindowEstimate
            One for each update period that ended within the batch, in which the screw moved and
            whose window holds both directions; often empty.
        """
        stretches = [
            slice(n, n + SAMPLES_AT_A_TIME) for n in range(0, voltage.size, SAMPLES_AT_A_TIME)
        ]
        return [found for s in stretches for found in self._take(voltage[s], position[s])]

    def _take(
        self, voltage: NDArray[np.float64], position: NDArray[np.float64]
    ) -> list[WindowEstimate]:
        angles = self._observer.update(voltage, position)
        skipped = min(self._to_skip, voltage.size)
        self._to_skip -= skipped
        self._next_sample += skipped
        self._theta_m = np.concatenate([self._theta_m, angles.theta_m[skipped:]])
        self._theta_d = np.concatenate([self._theta_d, angles.theta_d[skipped:]])
        # Differences need one sample before each block.
        used = max(self._theta_m.size - 1, 0) // self._block * self._block
        if not used:
            return []
        blocks = contact_sums(
            self._theta_m[: used + 1],
            self._theta_d[: used + 1],
            self._sample_time,
            self._settings.velocity_threshold,
            self._settings.rounding,
            self._block,
        )
        estimates = []
        for number, block in enumerate(blocks):
            sums = self._slide(block)
            gap = gap_from_sums(sums, self._settings.rounding)
            if gap is not None and (block.forward or block.backward):
                newest = self._next_sample + (number + 1) * self._block
                estimates.append(WindowEstimate(newest, gap, sums.forward, sums.backward))
        self._theta_m, self._theta_d = self._theta_m[used:], self._theta_d[used:]
        self._next_sample += used
        return estimates

    def _slide(self, newest: ContactSums) -> ContactSums:
        """Move the window on by one block and return the sums over it."""
        full = len(self._window) == self._window.maxlen
        oldest = self._window[0] if full else NO_CONTACT
        self._window.append(newest)
        total = self._in_window
        self._in_window = ContactSums(
            total.forward + newest.forward - oldest.forward,
            total.backward + newest.backward - oldest.backward,
            total.ceiled + newest.ceiled - oldest.ceiled,
            total.floored + newest.floored - oldest.floored,
        )
        return self._in_window
