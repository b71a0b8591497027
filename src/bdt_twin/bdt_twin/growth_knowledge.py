"""What is known of how fast the gap grows: a gap that jumps seems to grow for a while."""

import math

from bdt_twin.estimator import Estimate

USUAL = 3.0
"""Standard uncertainties up to which another growth is what the known one may have become."""
LONGEST_JUMP = 6.0
"""Time [s] after which growth that has come suddenly is no jump: a window has told it by then from
what comes after the jump alone."""


class GrowthKnowledge:
    """Tells growth that comes suddenly from wear.

    Parameters
    ----------
    usual_change : float
        Scale of the growth rate's change in one second [rad/s^1.5].

    Attributes
    ----------
    change : float
        The same as the last answer has told it, which is not less.
    """

    def __init__(self, usual_change: float) -> None:
        self._usual_change = self.change = usual_change
        self._steady: Estimate | None = None
        self._sudden_since: float | None = None

    def sudden(self, time: float, growth: float, uncertainty: float) -> float:
        """Return by how much growth differs from the known one; zero if that may have become it.

        Parameters
        ----------
        time : float
            When it is told [s].
        growth, uncertainty : float
            What is told, and its standard uncertainty [rad/s].

        Returns
        -------
        float
            The difference [rad/s].
        """
        known = self._steady
        # Growth that ends is no jump.
        if known is None or abs(growth) < abs(known.growth):
            return 0.0
        change = self.change * math.sqrt(max(time - known.time, 0.0))
        usual = USUAL * math.hypot(uncertainty, known.growth_uncertainty, change)
        difference = abs(growth - known.growth)
        return difference if difference > usual else 0.0

    def learn(self, answer: Estimate, sudden: float, change: float) -> None:
        """Take the growth of an answer.

        Parameters
        ----------
        answer : Estimate
            The answer.
        sudden : float
            What :meth:`sudden` has returned for its growth [rad/s].
        change : float
            Scale of the growth rate's change in one second that its window shows [rad/s^1.5].
        """
        since = self._sudden_since
        if sudden == 0.0 or (since is not None and answer.time - since > LONGEST_JUMP):
            self._steady, self._sudden_since = answer, None
        elif since is None:
            self._sudden_since = answer.time
        # A gap that rises and falls is not held to the even growth of wear.
        self.change = max(self._usual_change, change)
