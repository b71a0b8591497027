"""Effects of which a fit without them shows no evidence: when to try them, and what to believe.

A walk of the motor explains what they do about as well, so a window is fitted once more with one of
them. A trial that has failed leaves no trace, not even its work, which would keep others from being
made.
"""

import math

from bdt_twin.fit_result import Fit
from bdt_twin.machine_knowledge import TOP_MASS, VOLTAGE_LAG
from bdt_twin.model_factors import FACTORS
from bdt_twin.noise_levels import HARDLY_EXPLAINED, is_restless
from bdt_twin.unknowns import Unknowns

TRIED = frozenset((VOLTAGE_LAG, TOP_MASS))
"""Places in ``EFFECTS`` of those that are tried."""
TRIED_AGAIN = 3
"""Windows from the first trial of an effect to the second; then twice as many."""
LAG_GAIN = 10.0
"""Gain of log-likelihood by a voltage that is late, not the reading, for which it is taken so."""
TOP_MASS_GAIN = 15.0
"""Gain of log-likelihood by another mass of the top platform for which it has that."""
TOP_MASS_COVERAGE = 4.0
"""Standard uncertainties by which it has to be another one."""
LEAST_TOP_MASS = 0.01
"""Logarithm of the factor on this mass below which it is none."""


class TrialTimes:
    """Says when it is time to try an effect: less and less often, each by itself."""

    def __init__(self) -> None:
        self._pauses = dict.fromkeys(TRIED, TRIED_AGAIN)
        self._left = dict.fromkeys(self._pauses, 1)

    def is_due(self, effect: int) -> bool:
        """Count a window in which an effect may be tried; tell whether it is to be.

        Parameters
        ----------
        effect : int
            Its place in ``EFFECTS``.
        """
        self._left[effect] -= 1
        if self._left[effect] > 0:
            return False
        self._left[effect] = self._pauses[effect]
        self._pauses[effect] *= 2
        return True


def begun_with(effect: int, unknowns: Unknowns) -> Unknowns:
    """Return the unknowns with which the trial of an effect begins.

    Parameters
    ----------
    effect : int
        Place in ``EFFECTS``.
    unknowns : Unknowns
        Those of the fit without it.
    """
    if effect == VOLTAGE_LAG:
        return unknowns.with_late_voltage()
    return unknowns.with_other_top_mass()


def is_believed(effect: int, found: Fit, fit: Fit) -> bool:
    """Tell whether a machine has an effect that was tried.

    What other effects leave unexplained may want a voltage that is late and a reading that is
    early, which no machine has, and one more unknown lets a motor walk less that goes on to walk a
    lot. A mass that is another one for certain is one, however much of the motion is left.

    Parameters
    ----------
    effect : int
        Place in ``EFFECTS``.
    found, fit : Fit
        A window's fits with and without it.
    """
    gain = found.gain_over(fit)
    if effect == VOLTAGE_LAG:
        is_explained = not is_restless(found.levels, HARDLY_EXPLAINED)
        return gain >= LAG_GAIN and found.unknowns.has_late_voltage and is_explained
    machine, place = found.machine, len(FACTORS) + TOP_MASS
    certain = TOP_MASS_COVERAGE * math.sqrt(float(machine.covariance[place, place]))
    off = abs(float(machine.expected[place]))
    return gain >= TOP_MASS_GAIN and off > max(certain, LEAST_TOP_MASS)
