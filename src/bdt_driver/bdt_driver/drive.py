"""What a drive is to the driver node: five methods that only the hardware knows."""

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray


class Reading(NamedTuple):
    """What a drive has measured.

    Attributes
    ----------
    position : float
        Position of platform 3 now [m].
    voltage : float
        Motor voltage as applied since the reading before [V].
    samples : ndarray, shape (n, 2), or None
        From hardware with a sampling clock of its own: rows of motor voltage [V], in force from
        the sample on, and position [m], one for each sampling instant since the reading before,
        oldest first; without rows when there is none yet. None from a drive that samples when it
        is read.
    lost : int
        Number of samples that were lost before these, as their numbers or a counter tell.
    """

    position: float
    voltage: float
    samples: NDArray[np.float64] | None = None
    lost: int = 0


class Drive(Protocol):
    """Motor, amplifier and sensor.

    The driver node calls one method at a time, but for :meth:`stop`, which a second thread calls
    when another method does not return. Any exception of any method is a fault of the drive.
    """

    def open(self) -> None:
        """Connect; the motor gets no voltage."""

    def read(self) -> Reading | tuple[object, ...]:
        """Return position [m], voltage applied since the last reading [V], and samples if any."""

    def write(self, voltage: float) -> None:
        """Apply a motor voltage [V] until the next one."""

    def stop(self) -> None:
        """Take the voltage off the motor, now and whatever else goes on, until the next write."""

    def close(self) -> None:
        """Disconnect; called after :meth:`stop`, also when opening has failed."""
