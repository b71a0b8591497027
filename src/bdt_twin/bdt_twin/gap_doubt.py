"""How much less sure a gap is than the residual of its fit says."""

import math

import numpy as np

from bdt_twin.fit_doubt import FIRST_DOUBT
from bdt_twin.fit_result import Fit
from bdt_twin.machine_knowledge import YIELD_ANGLE
from bdt_twin.machine_memory import SMALLEST_FRICTION
from bdt_twin.noise_levels import is_restless
from bdt_twin.unknowns import SMALLEST_YIELD_ANGLE
from bdt_twin.wave_problem import WaveProblem
from bdt_twin.window_model import WindowModel

YIELDING_DOUBT = 0.05
"""Share of the angle by which friction yields that is not told."""
KNOWN_YIELDING, UNSEEN_YIELDING, UNEXPLAINED_YIELDING = 7e-4, 2e-3, 6e-3
"""Angles by which friction that yields may shift a gap beside what is told [rad]: where it is known
to yield, and where it is thought to be rigid, for certain and where that is open."""
ALIKE = 4.0
"""Reversals up to which it matters that they are alike: cogging that is unknown moves a motor that
hardly turns at each of them in the same way."""


def doubted(
    window: WindowModel,
    fit: Fit,
    at: float,
    uncertainty: float,
    reversals: int,
    *,
    is_first: bool,
) -> float:
    """Return the standard uncertainty of a gap with what its fit does not know [rad].

    That is how first motions mislead, and cogging that nobody has found in a motor with friction.

    Parameters
    ----------
    window : WindowModel
        Model and data.
    fit : Fit
        Their fit.
    at : float
        Time of the gap [s].
    uncertainty : float
        What the fit says [rad].
    reversals : int
        Reversals of the screw that have told the gap.
    is_first : bool
        Whether the first motions of a machine have told it that was not known before.
    """
    if is_first:
        uncertainty *= FIRST_DOUBT
    # Without friction cogging is no secret: it moves the motor from well to well.
    if window.cogs or fit.unknowns.friction < SMALLEST_FRICTION or not any(fit.levels[1:]):
        return uncertainty
    if is_restless(fit.levels):
        uncertainty *= math.sqrt(1.0 + ALIKE / reversals)
    fits = WaveProblem(window, fit).fits(fit.levels)
    weights = np.zeros(len(fits.moves))
    weights[: window.knots.size] = window.weights(np.array([at]))[:, 0]
    return math.hypot(uncertainty, fits.doubt(weights))


def yielding_doubt(fit: Fit, *, openness: float) -> float:
    """Return by how much friction that yields may shift a gap and not be told [rad].

    It does so alike at each reversal, which no residual shows.

    Parameters
    ----------
    fit : Fit
        The fit of a window.
    openness : float
        How open it is that friction which is thought to be rigid yields, from 0 to 1.
    """
    angle, friction = float(fit.unknowns.effects[YIELD_ANGLE]), fit.unknowns.friction
    if friction > 0.0 and angle >= SMALLEST_YIELD_ANGLE:
        return max(YIELDING_DOUBT * angle, KNOWN_YIELDING)
    if friction < SMALLEST_FRICTION:
        return 0.0
    if is_restless(fit.levels):
        openness = 1.0
    return UNSEEN_YIELDING + openness * (UNEXPLAINED_YIELDING - UNSEEN_YIELDING)
