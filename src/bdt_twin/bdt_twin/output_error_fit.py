"""Nonlinear least squares of the forward model over one window."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.elementary_functions import logarithm
from bdt_twin.block_residual import BlockResidual, variance_inflation
from bdt_twin.cramer_rao import fisher_information
from bdt_twin.fixed_order import dot, mean, product, solution, total, weighted_products
from bdt_twin.forward_model import StretchResponse
from bdt_twin.model_factors import FACTORS
from bdt_twin.window_model import INITIAL_CONDITION, Unknowns, WindowModel

FloatArray = NDArray[np.float64]

SMALLEST_NOISE = 1e-11
"""Standard deviation of a block's mean below which nothing is taken for noise [m]."""
FROM_MAD = 1.4826
"""Standard deviation of normal noise over its median absolute deviation."""
HUBER = 3.0
"""Standard deviations beyond which the residual of a block counts linearly."""

GAP_SPREAD = 10.0
"""Prior standard deviation of the gap [rad]: none, but a knot without data stays finite."""
GROWTH_SPREAD = math.radians(10.0)
"""Prior standard deviation of the mean growth rate [rad/s]."""
FACTOR_SPREAD = (0.3, 0.2, 0.7)
"""Prior standard deviations of the logarithms of ``FACTORS``."""
SHARE_SPREAD = 1.0
"""Prior standard deviation of where in the gap the motor begins."""

CHANGE_FREEDOM = 2.0
"""Degrees of freedom of Student's distribution, of which growth changes are: few are large."""

HALVINGS = 3
"""Halvings of a step that makes the fit worse, before the fit ends."""
SMALLEST_GAIN = 0.02
"""Gain of log-likelihood by a step that ends the fit; a half is one standard deviation."""


@dataclass(frozen=True, eq=False)
class Fit:
    """Result of a fit.

    Attributes
    ----------
    unknowns : Unknowns
        Where the fit ended.
    responses : list of StretchResponse
        The simulation there.
    noise : float
        Standard deviation of the residual's block means, without outliers [m].
    covariance : ndarray, shape (knots, knots)
        Covariance of the gap at the knots [rad^2].
    simulations : int
        Simulations made.
    """

    unknowns: Unknowns
    responses: list[StretchResponse]
    noise: float
    covariance: FloatArray
    simulations: int


class _Point(NamedTuple):
    """Unknowns with their simulation and residual."""

    unknowns: Unknowns
    responses: list[StretchResponse]
    residual: FloatArray


class WindowFit:
    """The least-squares problem of one window.

    Minimizes Huber's loss of the residual together with a weak prior. The part of it that matters
    says that the gap grows evenly, but for changes from knot to knot that have Student's
    distribution: what wear does little by little costs little, and a kink is not smeared over the
    window. The steps are Gauss and Newton's.

    Parameters
    ----------
    window : WindowModel
        Model and data.
    growth_change : float
        Scale of the growth rate's change in one second [rad/s^1.5].
    """

    def __init__(self, window: WindowModel, growth_change: float) -> None:
        self._window = window
        positions = [stretch.position for stretch in window.stretches]
        self._residual = BlockResidual(positions, window.block)
        self._prior = _prior(window.knots, len(positions))
        count, spacing = window.knots.size, float(window.knots[1] - window.knots[0])
        # Changes of growth at the knots, in multiples of their scale.
        scale = growth_change * spacing * math.sqrt(spacing)
        self._changes = np.diff(np.eye(count), 2, axis=0) / scale

    def solve(
        self,
        unknowns: Unknowns,
        steps: int,
        simulations: int,
        *,
        patience: int = 0,
        enough: float = math.inf,
    ) -> Fit:
        """Return the fit that begins at some unknowns.

        Parameters
        ----------
        unknowns : Unknowns
            Where to begin.
        steps, simulations : int
            Largest numbers of steps, and of simulations: halving a step costs one, too.
        patience : int
            Simulations after which the fit ends if its noise is larger than `enough`.
        enough : float
            Standard deviation of the residual's block means [m].
        """
        point, simulated = self._at(unknowns), 1
        for number in range(1, steps + 1):
            if simulated >= simulations:
                break
            if simulated >= patience and _deviation(point.residual) > enough:
                break
            settled = _noise(point.residual)
            # A model that is still wrong is wrong in the transients only, which are not outliers.
            rms = math.sqrt(mean(np.square(point.residual)))
            noise = max(settled, rms / 2**number)
            step = self._step(point, noise)
            vector = point.unknowns.as_vector()
            before, after = self._cost(point, noise), math.inf
            for _ in range(min(1 + HALVINGS, simulations - simulated)):
                trial = self._at(point.unknowns.from_vector(vector + step))
                simulated += 1
                after = self._cost(trial, noise)
                if after <= before:
                    break
                step = 0.5 * step
            if after > before:
                break
            point = trial
            if noise < 1.2 * settled and before - after < SMALLEST_GAIN + 1e-4 * before:
                break
        return self._result(point, simulated)

    def _at(self, unknowns: Unknowns) -> _Point:
        responses = self._window.simulate(unknowns)
        return _Point(
            unknowns, responses, self._residual.means([run.position for run in responses])
        )

    def _step(self, point: _Point, noise: float) -> FloatArray:
        jacobian = self._window.jacobian(point.unknowns, point.responses)
        weights = self._weights(point.residual, noise) / (noise * noise)
        pull = product(jacobian, weights * point.residual)
        prior = self._prior_at(point.unknowns)
        information = fisher_information(jacobian, weights) + prior
        scale = 1.0 / np.sqrt(np.diag(information))
        scaled = information * np.outer(scale, scale) + 1e-12 * np.eye(scale.size)
        gradient = pull - product(prior, point.unknowns.as_vector())
        return scale * solution(scaled, (scale * gradient)[:, None])[:, 0]

    def _weights(self, residual: FloatArray, noise: float) -> FloatArray:
        """Return the weights of the blocks that make squares out of Huber's loss."""
        bounded = np.maximum(np.abs(residual), HUBER * noise)
        weights: FloatArray = HUBER * noise / bounded
        return weights

    def _cost(self, point: _Point, noise: float) -> float:
        """Return the negative log-likelihood of unknowns and data, but for a constant."""
        size = np.abs(point.residual) / noise
        loss = np.where(size <= HUBER, 0.5 * np.square(size), HUBER * (size - 0.5 * HUBER))
        vector = point.unknowns.as_vector()
        changes = product(self._changes, point.unknowns.gaps)
        rare = 0.5 * (CHANGE_FREEDOM + 1.0) * logarithm(1.0 + np.square(changes) / CHANGE_FREEDOM)
        return total(loss) + total(rare) + 0.5 * dot(vector, product(self._prior, vector))

    def _prior_at(self, unknowns: Unknowns) -> FloatArray:
        """Return the inverse covariance of the unknowns before any data; their means are zero."""
        changes, count = product(self._changes, unknowns.gaps), unknowns.gaps.size
        weights = (CHANGE_FREEDOM + 1.0) / (CHANGE_FREEDOM + np.square(changes))
        prior = self._prior.copy()
        prior[:count, :count] += weighted_products(self._changes.T, weights)
        return prior

    def _result(self, point: _Point, simulations: int) -> Fit:
        noise, deviation = _noise(point.residual), _deviation(point.residual)
        bounded = np.clip(point.residual, -HUBER * noise, HUBER * noise)
        jacobian = self._window.jacobian(point.unknowns, point.responses)
        weights = self._weights(point.residual, noise) / (deviation * deviation)
        # A residual that is not white says less than its samples are many.
        weights /= variance_inflation(bounded, self._window.block_rate)
        information = fisher_information(jacobian, weights) + self._prior_at(point.unknowns)
        covariance = solution(information, np.eye(len(information)))
        knots = self._window.knots.size
        return Fit(
            point.unknowns,
            point.responses,
            deviation,
            covariance[:knots, :knots],
            simulations,
        )


def _noise(residual: FloatArray) -> float:
    """Return the standard deviation of a residual, whatever the outliers [m]."""
    return max(SMALLEST_NOISE, FROM_MAD * float(np.median(np.abs(residual))))


def _deviation(residual: FloatArray) -> float:
    """Return the standard deviation of a residual whose outliers are brought back [m]."""
    most = HUBER * _noise(residual)
    return max(SMALLEST_NOISE, math.sqrt(mean(np.square(np.clip(residual, -most, most)))))


def _prior(knots: FloatArray, stretches: int) -> FloatArray:
    """Return the inverse covariance of the unknowns but for the changes of growth."""
    count, spacing = knots.size, float(knots[1] - knots[0])
    growth = np.diff(np.eye(count), axis=0) / spacing
    size = count + len(FACTORS) + len(INITIAL_CONDITION) * stretches
    prior = np.zeros((size, size))
    prior[:count, :count] = np.eye(count) / (GAP_SPREAD * GAP_SPREAD)
    spread = np.full(count - 1, 1.0 / (GROWTH_SPREAD * GROWTH_SPREAD * (count - 1)))
    prior[:count, :count] += weighted_products(growth.T, spread)
    factors = np.arange(count, count + len(FACTORS))
    prior[factors, factors] = 1.0 / np.square(FACTOR_SPREAD)
    shares = np.arange(count + len(FACTORS), size, len(INITIAL_CONDITION))
    prior[shares, shares] = 1.0 / (SHARE_SPREAD * SHARE_SPREAD)
    return prior
