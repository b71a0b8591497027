"""How sure it is whether friction yields: what windows tell that are fitted both ways adds up.

A single window tells little, for a fit that has not come to its end may gain or lose by anything.
So none adds more than a bounded gain, and what has gone on for long is not overthrown at once.
"""

from collections.abc import Sequence

MOST_GAIN = 30.0
"""Log-likelihood by which one window may change the evidence."""
LARGE_ANGLE = 6e-3
"""Yield angle from which on a gain counts in full [rad]. A smaller one shifts a gap by less, so
there is time, and cogging that nobody has found looks like it for a while."""
EXPLAINED_GAIN = 20.0
"""Evidence for the machine's friction by a window that it explains: no other can gain there."""
CERTAIN, BELIEVED = 100.0, 75.0
"""Evidence with which the machine's friction is certain, and with which the other is believed."""
UNFINISHED = 150.0
"""Loss of log-likelihood from which on a fit with the other friction has not come to its end."""
ALIKE = 1.5
"""Ratio of the yield angles of two windows below which they are those of one friction."""
DIFFERENCE_DOUBT = 0.6
"""Standard uncertainty over the difference of two gaps of which either may be true."""


class FrictionEvidence:
    """Evidence for the other friction than that which a machine is thought to have."""

    def __init__(self) -> None:
        self._gain = self._angle = self._difference = 0.0

    @property
    def is_certain(self) -> bool:
        """Whether nothing speaks for the other friction."""
        return self._gain <= -CERTAIN

    @property
    def is_against(self) -> bool:
        """Whether the other friction is to be believed."""
        return self._gain >= BELIEVED

    @property
    def openness(self) -> float:
        """How open it is which friction is the true one, from 0 for certain to 1."""
        return min(1.0 + self._gain / CERTAIN, 1.0)

    @property
    def doubt(self) -> float:
        """Standard uncertainty of a gap because the other friction may be the true one [rad]."""
        return DIFFERENCE_DOUBT * self.openness * self._difference

    def explained(self) -> None:
        """Take note of a window that the machine's friction explains."""
        self._gain = max(self._gain - EXPLAINED_GAIN, -CERTAIN)

    def compared(self, gain: float, difference: float, angle: float | None) -> None:
        """Take note of a window that was fitted both ways.

        Parameters
        ----------
        gain : float
            Gain of log-likelihood by the other friction.
        difference : float
            Difference of the gaps with either friction [rad].
        angle : float or None
            Angle by which the other friction yields [rad]; None for rigid friction. What gains by
            one angle now and by another one then is no friction.
        """
        if gain < -UNFINISHED:
            return
        most = MOST_GAIN
        if angle is not None and gain > 0.0:
            most *= min(angle / LARGE_ANGLE, 1.0)
            if self._gain > 0.0 and not are_alike([angle, self._angle], ALIKE):
                self._gain = 0.0
            self._angle = angle
        self._gain = max(self._gain + min(max(gain, -MOST_GAIN), most), -CERTAIN)
        self._difference = difference

    def turn(self) -> None:
        """Begin anew with the friction that was the other one."""
        self._gain = 0.0


def are_alike(angles: Sequence[float], ratio: float) -> bool:
    """Tell whether yield angles that several fits have found are those of one friction.

    Parameters
    ----------
    angles : sequence of float
        The angles [rad].
    ratio : float
        Ratio of the largest to the smallest one below which they are.
    """
    return max(angles) < ratio * min(angles)
