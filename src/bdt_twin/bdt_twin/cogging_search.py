"""How many periods of cogging a motor has in a turn, from what is left unexplained by a fit."""

from typing import NamedTuple

from bdt_twin.cogging_waves import FEWEST_COGS
from bdt_twin.fit_result import Fit
from bdt_twin.noise_levels import quiet
from bdt_twin.wave_problem import WaveProblem
from bdt_twin.window_model import WindowModel


class CoggingEvidence(NamedTuple):
    """Number of periods in a turn that explains most, and the gain of log-likelihood by it."""

    cogs: int
    gain: float


def cogging_evidence(window: WindowModel, fit: Fit) -> CoggingEvidence:
    """Return the number of periods in a turn for which there is most evidence.

    Parameters
    ----------
    window : WindowModel
        Model and data, with or without cogging.
    fit : Fit
        Their fit.

    Returns
    -------
    CoggingEvidence
        The number, and its gain over that of the window, or over no cogging.
    """
    problem, found = WaveProblem(window, fit), []
    # A walk of the motor may be cogging that nobody has looked for, and would hide it.
    for levels in (fit.levels, quiet(fit.levels)):
        gains = problem.fits(levels).gains
        best = int(gains.argmax())
        known = float(gains[window.cogs - FEWEST_COGS]) if window.cogs else 0.0
        found.append(CoggingEvidence(FEWEST_COGS + best, float(gains[best]) - known))
    return max(found, key=lambda each: each.gain)
