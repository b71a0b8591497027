"""Gap and growth at a time, with their uncertainties, from the fit of a window."""

import math

import numpy as np
from numpy.typing import NDArray

from bdt_plant.plant import PlantModel
from bdt_twin.fit_doubt import excess
from bdt_twin.fit_result import Fit
from bdt_twin.fixed_order import dot, mean, product
from bdt_twin.window_model import WindowModel

FloatArray = NDArray[np.float64]

RESPONSE = 10.0
"""Time in which the upper platform answers the screw, in sqrt(m/k): a period of its slowest
vibration."""
UNLIKE = 5.5
"""Standard deviations of the mean square of white noise by which that of the innovations exceeds
its mean where the platform answers a reversal otherwise than the model."""
JUMP = 2
"""Changes of growth that a jump of the gap is, up and down again."""


def answered_reversals(
    model: PlantModel, window: WindowModel, fit: Fit, newest: float
) -> list[float]:
    """Return the times of the screw's reversals that the platform has answered [s].

    Where the gap has just jumped the model reverses before the machine does. Only when the
    platform has had the time to follow do the data tell one from the other; and where it follows
    otherwise than the model has it, or only with a push, the gap may have jumped in spite of all
    that the windows before have told.

    Parameters
    ----------
    model : PlantModel
        The mechanism.
    window : WindowModel
        Model and data.
    fit : Fit
        Their fit.
    newest : float
        Time of the newest sample [s].
    """
    response = RESPONSE * math.sqrt(model.structure.mass / model.structure.stiffness)
    times = [time for time in window.reversals(fit.responses) if time <= newest - response]
    ends = np.concatenate(
        [
            (stretch.first + window.block * np.arange(1, run.screw.size + 1)) / window.sampling_rate
            for stretch, run in zip(window.stretches, fit.responses, strict=True)
        ]
    )
    negligible = fit.negligible(window.motion)
    while times:
        answer = (ends > times[-1]) & (ends <= times[-1] + response)
        if _is_explained(fit.innovations[answer], fit.pushed[answer], negligible):
            break
        times.pop()
    return times


def _is_explained(innovations: FloatArray, pushed: FloatArray, negligible: float) -> bool:
    """Tell whether the platform answers as the model has it."""
    # What a hole has hidden is not explained.
    if not innovations.size or pushed.any():
        return False
    return mean(np.square(innovations)) < negligible * negligible or excess(innovations) < UNLIKE


def growth_change_of(window: WindowModel, fit: Fit) -> float:
    """Return how much growth changes in one second in a fit, jumps left out [rad/s^1.5]."""
    spacing = float(window.knots[1] - window.knots[0])
    changes = np.sort(np.abs(np.diff(fit.unknowns.gaps, 2)))[:-JUMP]
    return mean(changes) / (spacing * math.sqrt(spacing)) if changes.size else 0.0


def gap_at(window: WindowModel, fit: Fit, at: float) -> tuple[float, float]:
    """Return the gap at a time and its standard uncertainty [rad]."""
    gaps, knots = fit.unknowns.gaps, window.knots
    weights = window.weights(np.array([at]))[:, 0]
    # Where growth changes between two knots, the gap is off the straight line between them by up
    # to an eighth of the change per spacing; the changes found nearby tell how much.
    knot = int(np.searchsorted(knots, at, side="right")) - 1
    changes = np.abs(np.diff(gaps, 2))[max(knot - 2, 0) : knot + 1]
    bend = float(changes.max(initial=0.0)) / 8
    variance = dot(weights, product(fit.gap_covariance, weights))
    # What the next step would change is not known yet.
    pending = dot(weights, fit.pending[: gaps.size])
    return dot(weights, gaps), math.sqrt(variance + bend * bend + pending * pending)


def growth_at(window: WindowModel, fit: Fit, at: float) -> tuple[float, float]:
    """Return the growth rate over four knots before a time and its uncertainty [rad/s]."""
    spacing = float(window.knots[1] - window.knots[0])
    before = max(at - 4 * spacing, float(window.knots[0]))
    after = max(at, before + spacing)
    earlier, later = window.weights(np.array([before, after])).T
    weights = (later - earlier) / (after - before)
    uncertainty = math.sqrt(dot(weights, product(fit.gap_covariance, weights)))
    return dot(weights, fit.unknowns.gaps), uncertainty
