"""The paper's estimator of the backlash gap (eqs 12, 13 and 14), as a stream."""

from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.quantities import quantity, validate
from bdt_plant.plant import PlantModel
from bdt_twin.angle_observer import AngleObserver


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


class GapEstimate(NamedTuple):
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


class ContactSums(NamedTuple):
    """Sums over samples in contact, in multiples of l/2: integers, so no order rounds differently.

    Attributes
    ----------
    forward, backward : int
        Numbers of samples with the screw moving forward (t_+) and backward (t_-).
    ceiled, floored : int
        Sums of the rounded angle differences over t_+ and t_-.
    """

    forward: int
    backward: int
    ceiled: int
    floored: int


def contact_sums(
    theta_m: NDArray[np.float64],
    theta_d: NDArray[np.float64],
    sample_time: float,
    velocity_threshold: float,
    rounding: float,
    block: int,
) -> list[ContactSums]:
    """Return the sums of eq. 13, one for each `block` of samples.

    Parameters
    ----------
    theta_m, theta_d : ndarray, shape (1 + n * block,)
        Aligned angles [rad]; the first sample only serves the first difference.
    sample_time : float
        Sample time [s].
    velocity_threshold : float
        Speed of the lead screw above which it counts as moving [rad/s].
    rounding : float
        Scale l [deg]; angles are rounded to multiples of l/2 (eq. 14).
    block : int
        Number of samples in a block.
    """
    threshold = velocity_threshold * sample_time
    screw, motor = np.diff(theta_d), np.diff(theta_m)
    # By eq. 6 a screw that moves turns with the motor. Around a reversal the inverse filter leaves
    # a few samples with opposite signs; one of them alone in a window would make the gap zero.
    forward, backward = (screw > threshold) & (motor > 0), (screw < -threshold) & (motor < 0)
    difference = np.rad2deg(theta_m[1:] - theta_d[1:]) / (0.5 * rounding)
    columns = (
        forward,
        backward,
        np.where(forward, np.ceil(difference), 0.0),
        np.where(backward, np.floor(difference), 0.0),
    )
    sums = np.stack([column.reshape(-1, block).sum(axis=1) for column in columns], axis=1)
    return [ContactSums(*(int(x) for x in row)) for row in sums]


def gap_from_sums(sums: list[ContactSums], rounding: float) -> float | None:
    """Return the gap theta_b [rad] of eq. 13, or None unless both directions occur.

    Parameters
    ----------
    sums : list of ContactSums
        Blocks of the window.
    rounding : float
        Scale l [deg] with which the sums were made.
    """
    forward, backward, ceiled, floored = (sum(column) for column in zip(*sums, strict=True))
    if not forward or not backward:
        return None
    return float(np.deg2rad(0.5 * rounding * (ceiled / forward - floored / backward)))


class InverseFilterEstimator:
    """Streaming estimator: the same estimates for any split of the same data into batches.

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
        self.restart()

    def restart(self) -> None:
        """Forget all samples; the next one has the index zero."""
        self._observer.restart()
        self._window.clear()
        self._theta_m = np.empty(0)
        self._theta_d = np.empty(0)
        self._next_sample = 0
        self._to_skip = self._observer.settling

    def update(
        self, voltage: NDArray[np.float64], position: NDArray[np.float64]
    ) -> list[GapEstimate]:
        """Take the next batch of samples.

        Parameters
        ----------
        voltage, position : ndarray, shape (n,)
            Motor voltage u [V] and position q3 of platform 3 [m].

        Returns
        -------
        list of GapEstimate
            One for each update period that ended within the batch, in which the screw moved and
            whose window holds both directions; often empty.
        """
        angles = self._observer.update(voltage, position)
        skipped = min(self._to_skip, voltage.size)
        self._to_skip -= skipped
        self._next_sample += skipped
        self._theta_m = np.concatenate([self._theta_m, angles.theta_m[skipped:]])
        self._theta_d = np.concatenate([self._theta_d, angles.theta_d[skipped:]])
        # Differences need one sample before each block.
        blocks = max(self._theta_m.size - 1, 0) // self._block
        used = blocks * self._block
        sums = contact_sums(
            self._theta_m[: used + 1],
            self._theta_d[: used + 1],
            self._sample_time,
            self._settings.velocity_threshold,
            self._settings.rounding,
            self._block,
        )
        estimates = []
        for number, block in enumerate(sums):
            self._window.append(block)
            gap = gap_from_sums(list(self._window), self._settings.rounding)
            if gap is not None and (block.forward or block.backward):
                newest = self._next_sample + (number + 1) * self._block
                forward = sum(item.forward for item in self._window)
                backward = sum(item.backward for item in self._window)
                estimates.append(GapEstimate(newest, gap, forward, backward))
        self._theta_m, self._theta_d = self._theta_m[used:], self._theta_d[used:]
        self._next_sample += used
        return estimates
