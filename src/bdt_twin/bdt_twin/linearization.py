"""The problem of a fit around its end: what the data tell of the unknowns, and what they would.

Of many fits nobody asks: they were tried, and another one explains more. So it is worked out, which
takes as long as a step of the fit, once somebody does.
"""

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_twin.fixed_order import dot
from bdt_twin.information import inverse, solved
from bdt_twin.machine_knowledge import EFFECT_SPREAD, EFFECTS

FloatArray = NDArray[np.float64]


class Slopes(NamedTuple):
    """Slopes of the log-likelihood at the end of a fit.

    Attributes
    ----------
    told : ndarray, shape (unknowns, unknowns)
        Information of the data.
    prior : ndarray, shape (unknowns, unknowns)
        Inverse covariance of the unknowns before any data.
    gradient : ndarray, shape (unknowns,)
        Slope of the log-likelihood, that of the prior with it.
    """

    told: FloatArray
    prior: FloatArray
    gradient: FloatArray

    @property
    def information(self) -> FloatArray:
        """Information of the data and of what was known before, shape (unknowns, unknowns)."""
        return self.told + self.prior


class Linearization:
    """The problem of a fit around its end.

    Parameters
    ----------
    work_out : callable
        Returns the :class:`Slopes` there.
    first_effect : int
        Place of the first of ``machine_knowledge.EFFECTS`` among the unknowns.
    covariance : ndarray, shape (unknowns, unknowns), optional
        Covariance of the unknowns, if another one than the slopes tell is known.
    """

    def __init__(
        self,
        work_out: Callable[[], Slopes],
        first_effect: int,
        covariance: FloatArray | None = None,
    ) -> None:
        self._work_out, self._first_effect, self._known = work_out, first_effect, covariance

    def with_covariance(self, covariance: FloatArray) -> "Linearization":
        """Return the same with another covariance of the unknowns."""
        return Linearization(lambda: self.slopes, self._first_effect, covariance)

    @cached_property
    def slopes(self) -> Slopes:
        """Slopes of the log-likelihood."""
        return self._work_out()

    @cached_property
    def covariance(self) -> FloatArray:
        """Covariance of the unknowns, shape (unknowns, unknowns)."""
        if self._known is not None:
            return self._known
        return inverse(self.slopes.information)

    @cached_property
    def pending(self) -> FloatArray:
        """The step that comes next, shape (unknowns,)."""
        return solved(self.slopes.information, self.slopes.gradient)

    @cached_property
    def evidence(self) -> FloatArray:
        """Gain of log-likelihood by each effect if it were free, shape (effects,)."""
        told, _, gradient = self.slopes
        information, gains = self.slopes.information, np.zeros(len(EFFECTS))
        for effect, spread in enumerate(EFFECT_SPREAD):
            place = self._first_effect + effect
            others = np.delete(np.arange(len(information)), place)
            coupling = information[others, place]
            explained = solved(information[np.ix_(others, others)], coupling)
            own = told[place, place] + 1.0 / (spread * spread) - dot(coupling, explained)
            slope = gradient[place] - dot(explained, gradient[others])
            if own > 0.0:
                gains[effect] = 0.5 * slope * slope / own
        return gains
