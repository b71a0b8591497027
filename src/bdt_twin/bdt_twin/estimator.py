"""What every estimator of the backlash gap is to the twin: batches in, estimates out."""

import math
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray


class Estimate(NamedTuple):
    """What an estimator knows about the gap at one time.

    Attributes
    ----------
    time : float
        Time for which the gap is stated [s], not after the newest sample; later it is expected to
        be ``gap + growth * (t - time)``.
    gap : float
        Backlash gap theta_b [rad]; NaN as long as nothing was learned.
    uncertainty : float
        Standard uncertainty of the gap [rad]; infinite as long as nothing was learned, NaN from an
        estimator that does not know how sure it is.
    growth, growth_uncertainty : float
        Growth rate of the gap from that time on and its standard uncertainty [rad/s]; 0 from an
        estimator that does not look for it.
    gain_correction : float
        Factor by which the motor's gain differs from the model's [-].
    reversals : int
        Number of reversals of the lead screw's motion that the estimate rests on.
    reason : str
        Why these samples gave no answer, so that what is known is kept with an uncertainty that
        grows: the last answer, or a gap that was too unsure for one; empty when they did.
    age : float
        Time from `time` to the newest sample that was looked at [s]; 0 from an estimator that
        states the gap for its newest sample.
    voltage_offset, voltage_offset_uncertainty : float
        Voltage that the amplifier adds to the command and its standard uncertainty [V]; infinite
        as long as nothing is known of it, and from an estimator that does not look for it.
    """

    time: float
    gap: float
    uncertainty: float = math.nan
    growth: float = 0.0
    growth_uncertainty: float = 0.0
    gain_correction: float = 1.0
    reversals: int = 0
    reason: str = ""
    age: float = 0.0
    voltage_offset: float = 0.0
    voltage_offset_uncertainty: float = math.inf

    @property
    def is_known(self) -> bool:
        """Whether there is a gap at all."""
        return math.isfinite(self.gap)

    @property
    def compensation(self) -> float | None:
        """Voltage that cures the amplifier's offset [V]; None as long as that is not known."""
        # Subtracted from zero: there is no offset of -0.0.
        is_known = math.isfinite(self.voltage_offset_uncertainty)
        return 0.0 - self.voltage_offset if is_known else None


class TelemetryRejectedError(ValueError):
    """A batch is of no use to the estimator; the text says why."""


class Estimator(Protocol):
    """Turns telemetry into estimates, the same ones however it is split into batches."""

    def restart(self) -> None:
        """Forget everything: another run begins."""

    def update(self, batch: NDArray[np.float64], *, newest_only: bool = False) -> Estimate | None:
        """Take the next batch.

        Parameters
        ----------
        batch : ndarray, shape (n, 3)
            Telemetry rows (t [s], u [V], q3 [m]), oldest first.
        newest_only : bool
            Whether estimates that became due before the newest one may be left out, because
            whoever asks is behind.

        Returns
        -------
        Estimate or None
            The newest estimate that became due within the batch; None if none did.

        Raises
        ------
        TelemetryRejectedError
            For a batch that is of no use: empty, not finite, or going back in time. What the
            estimator needs to do about it (restart, or go on across the hole) it has done.
        """


def estimate_values(estimate: Estimate | None) -> dict[str, float | int | str | None]:
    """Return an estimate as the diagnostics tell it, by name."""
    if estimate is None:
        return {"gap_estimate_rad": None}
    return {
        "gap_estimate_rad": estimate.gap,
        "gap_uncertainty_rad": estimate.uncertainty,
        "gap_growth_rad_per_s": estimate.growth,
        "gain_correction": estimate.gain_correction,
        "reversals": estimate.reversals,
        "voltage_offset_estimate_v": estimate.voltage_offset,
        "voltage_offset_uncertainty_v": estimate.voltage_offset_uncertainty,
        "nothing_learned_because": estimate.reason,
    }
