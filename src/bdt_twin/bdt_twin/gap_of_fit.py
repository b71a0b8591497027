"""Gap and growth at a time, with their uncertainties, from the fit of a window."""

import math

import numpy as np

from bdt_twin.fit_result import Fit
from bdt_twin.fixed_order import dot, product
from bdt_twin.window_model import WindowModel


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
