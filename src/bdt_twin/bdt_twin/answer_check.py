"""Whether a gap that a fit has found is stated: a wrong answer that is sure is worse than none."""

import math
from typing import NamedTuple

from bdt_twin.gap_knowledge import SAME_REVERSAL
from bdt_twin.innovations import NoiseLevels
from bdt_twin.noise_levels import HARDLY_EXPLAINED, is_noticed, is_restless, motor_walk

DOUBTFUL = math.radians(0.1)
"""Standard uncertainty above which a gap is compared with what was known before [rad]."""
CONTRADICTION = 2.0
"""Standard uncertainties between two gaps that contradict each other; windows share their data."""
HARMLESS = math.radians(0.3)
"""Difference of two gaps that is no contradiction however sure both are [rad]."""
LESS_EXPLAINED = 1.06
"""Prediction error over that of the last answer from which on a window is explained less well: a
fit that is still on its way to a gap that has jumped."""
LONG_AFTER = 3.0
"""Time between reversals after which a gap is confirmed [s] also by a window that is explained less
well, or whose motor walks as it did not before: noise may grow, too."""
FIRST_SHARE = 0.5
"""Share of the largest uncertainty that such a machine's first answer may have."""
SUDDEN_WALK = 30.0
"""Walk of the motor in a second, over the noise of a reading, that may hide that a gap jumped."""
SUDDEN_RISE = 4.0
"""Ratio of such a walk to the one before from which on it is no habit of the machine."""
MOST_PUSHED = 0.025
"""Share of a window in which something may push a platform. Pushes of 50 ms every 7 s take 0.009;
what takes more, as guides in which the platforms stick, is no push but a model that is wrong."""


class Doubt(NamedTuple):
    """Why a gap is not stated.

    Attributes
    ----------
    reason : str
        Why; empty if it is stated.
    is_rough : bool
        Whether the gap is worth knowing roughly: it is just not sure enough, or all there is.
    """

    reason: str = ""
    is_rough: bool = False


class AnswerCheck:
    """Looks at one answer after the other.

    Parameters
    ----------
    largest_uncertainty : float
        Standard uncertainty of the gap above which a window has taught nothing [rad].
    """

    def __init__(self, largest_uncertainty: float) -> None:
        self._largest = largest_uncertainty
        self._sure_before = self._stated_before = False
        self._contradiction = self._contradicted_at = 0.0
        self._usual_walk = math.inf
        self._walks_since: float | None = None

    def unexplained(self) -> None:
        """Take note of a window that no fit explains."""
        self._sure_before = self._stated_before = False

    def doubt(
        self,
        gap: float,
        uncertainty: float,
        expected: tuple[float, float] | None,
        levels: NoiseLevels,
        *,
        at: float,
        pushed: float,
        is_surprised: bool,
        error_ratio: float,
    ) -> Doubt:
        """Return why a gap is not stated, if it is not.

        Parameters
        ----------
        gap, uncertainty : float
            The gap and its standard uncertainty [rad].
        expected : tuple of float, or None
            The same, as known before; None if nothing was.
        levels : NoiseLevels
            Noise of the machine.
        at : float
            Time of the reversal that has told the gap [s].
        pushed : float
            Share of the window in which something pushed a platform, which a gap that has just
            jumped looks like.
        is_surprised : bool
            Whether the newest data are explained worse than the others.
        error_ratio : float
            Prediction error over that of the last answer; 1 if there was none.
        """
        reason = self._unsure_because(uncertainty, levels)
        is_rough = bool(reason) and not is_surprised
        if not reason and is_surprised:
            reason = "the newest data are not explained yet"
        is_sudden = not reason and self._walks_suddenly(levels, at)
        if not reason:
            is_compared = uncertainty >= DOUBTFUL or pushed > 0.0
            is_unsettled = error_ratio > LESS_EXPLAINED and uncertainty >= DOUBTFUL
            reason = self._disbelieved_because(
                gap,
                uncertainty,
                expected if is_compared else None,
                at,
                patience=LONG_AFTER if is_unsettled else SAME_REVERSAL,
                is_sudden=is_sudden,
            )
        if not reason and pushed > MOST_PUSHED:
            share = f"{100.0 * pushed:.2g} %"
            reason = f"something holds or pushes the platforms for {share} of the time"
            # A gap by a wrong model is better than none, and no better than an answer.
            is_rough = expected is None
        # A motor that walks a lot, and did not walk before, may be one whose gap has just jumped.
        self._sure_before = uncertainty <= self._largest and is_noticed(levels)
        # An answer that waits because of such a walk leaves no silence.
        self._stated_before = not reason or is_sudden
        return Doubt(reason, is_rough)

    def _unsure_because(self, uncertainty: float, levels: NoiseLevels) -> str:
        unknown = f"unknown by {math.degrees(uncertainty):.3g} deg"
        if uncertainty > self._largest:
            return f"the gap remains {unknown}"
        if is_restless(levels, HARDLY_EXPLAINED):
            if not self._sure_before:
                return (
                    "the next window has to confirm the gap of a machine that is hardly explained"
                )
            if not self._stated_before and uncertainty > FIRST_SHARE * self._largest:
                return f"the gap of a machine that is hardly explained remains {unknown}"
        return ""

    def _walks_suddenly(self, levels: NoiseLevels, at: float) -> bool:
        """Tell whether the motor walks as it did not before, and has not been for long."""
        walk, since = motor_walk(levels), self._walks_since
        is_large = is_restless(levels, SUDDEN_WALK) and walk > SUDDEN_RISE * self._usual_walk
        if since is None and is_large:
            since = at
        if since is not None and (at > since + LONG_AFTER or walk <= self._usual_walk):
            since = None
        if since is None:
            self._usual_walk = walk
        self._walks_since = since
        return since is not None

    def _disbelieved_because(
        self,
        gap: float,
        uncertainty: float,
        expected: tuple[float, float] | None,
        at: float,
        *,
        patience: float,
        is_sudden: bool,
    ) -> str:
        """Return why a gap is not believed after what was known before, if it is not."""
        if expected is not None:
            before, its_uncertainty = expected
            off = gap - before
            spread = max(CONTRADICTION * math.hypot(uncertainty, its_uncertainty), HARMLESS)
            is_repeated = abs(off - self._contradiction) < abs(off)
            # Said by two reversals, it is what was known before that was wrong. Windows with the
            # same one may all choose the wrong one of two gaps that explain it.
            is_confirmed = is_repeated and at - self._contradicted_at > patience
            if abs(off) <= spread and is_sudden:
                return "a sudden walk of the motor may hide that the gap has jumped"
            if abs(off) > spread and not is_confirmed:
                if not is_repeated:
                    self._contradiction, self._contradicted_at = off, at
                return "the gap contradicts what was known before"
        self._contradiction = 0.0
        return ""
