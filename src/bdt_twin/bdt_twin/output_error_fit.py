"""Nonlinear least squares of the forward model over one window."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_twin.block_residual import BlockResidual, correlated_blocks
from bdt_twin.cramer_rao import information_of
from bdt_twin.forward_model import WindowRun
from bdt_twin.model_factors import FACTORS
from bdt_twin.window_model import BEGINNING, Unknowns, WindowModel

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
    runs : list of WindowRun
        The simulation there.
    noise : float
        Standard deviation of the residual's block means, without outliers [m].
    covariance : ndarray, shape (knots, knots)
        Covariance of the gap at the knots [rad^2].
    simulations : int
        Simulations made.
    """

    unknowns: Unknowns
    runs: list[WindowRun]
    noise: float
    covariance: FloatArray
    simulations: int


class _Point(NamedTuple):
    """Unknowns with their simulation and residual."""

    unknowns: Unknowns
    runs: list[WindowRun]
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
        self._changes = np.diff(np.eye(count), 2, axis=0) / (growth_change * spacing**1.5)

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
            rms = math.sqrt(float(np.mean(point.residual**2)))
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
        runs = self._window.run(unknowns)
        return _Point(unknowns, runs, self._residual.means([run.position for run in runs]))

    def _step(self, point: _Point, noise: float) -> FloatArray:
        slopes = self._window.slopes(point.unknowns, point.runs)
        weights = self._weights(point.residual, noise) / noise**2
        pull = np.einsum("ik,k->i", slopes, weights * point.residual)
        prior = self._prior_at(point.unknowns)
        information = information_of(slopes, weights) + prior
        scale = 1.0 / np.sqrt(np.diag(information))
        gradient = pull - prior @ point.unknowns.as_vector()
        step: FloatArray = scale * np.linalg.solve(
            information * np.outer(scale, scale) + 1e-12 * np.eye(scale.size), scale * gradient
        )
        return step

    def _weights(self, residual: FloatArray, noise: float) -> FloatArray:
        """Return the weights of the blocks that make squares out of Huber's loss."""
        bounded = np.maximum(np.abs(residual), HUBER * noise)
        weights: FloatArray = HUBER * noise / bounded
        return weights

    def _cost(self, point: _Point, noise: float) -> float:
        """Return the negative log-likelihood of unknowns and data, but for a constant."""
        size = np.abs(point.residual) / noise
        loss = np.where(size <= HUBER, 0.5 * size**2, HUBER * (size - 0.5 * HUBER))
        vector = point.unknowns.as_vector()
        changes = self._changes @ point.unknowns.gaps
        rare = 0.5 * (CHANGE_FREEDOM + 1.0) * np.log1p(changes**2 / CHANGE_FREEDOM)
        return float(loss.sum() + rare.sum()) + 0.5 * float(vector @ self._prior @ vector)

    def _prior_at(self, unknowns: Unknowns) -> FloatArray:
        """Return the inverse covariance of the unknowns before any data; their means are zero."""
        changes, count = self._changes @ unknowns.gaps, unknowns.gaps.size
        weights = (CHANGE_FREEDOM + 1.0) / (CHANGE_FREEDOM + changes**2)
        prior = self._prior.copy()
        prior[:count, :count] += (self._changes.T * weights) @ self._changes
        return prior

    def _result(self, point: _Point, simulations: int) -> Fit:
        noise, deviation = _noise(point.residual), _deviation(point.residual)
        bounded = np.clip(point.residual, -HUBER * noise, HUBER * noise)
        slopes = self._window.slopes(point.unknowns, point.runs)
        weights = self._weights(point.residual, noise) / deviation**2
        # A residual that is not white says less than its samples are many.
        weights /= correlated_blocks(bounded, self._window.block_rate)
        information = information_of(slopes, weights) + self._prior_at(point.unknowns)
        covariance: FloatArray = np.linalg.inv(information).astype(np.float64)
        knots = self._window.knots.size
        return Fit(
            point.unknowns,
            point.runs,
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
    return max(SMALLEST_NOISE, math.sqrt(float(np.mean(np.clip(residual, -most, most) ** 2))))


def _prior(knots: FloatArray, stretches: int) -> FloatArray:
    """Return the inverse covariance of the unknowns but for the changes of growth."""
    count, spacing = knots.size, float(knots[1] - knots[0])
    growth = np.diff(np.eye(count), axis=0) / spacing
    size = count + len(FACTORS) + len(BEGINNING) * stretches
    prior = np.zeros((size, size))
    prior[:count, :count] = np.eye(count) / GAP_SPREAD**2
    prior[:count, :count] += growth.T @ growth / (GROWTH_SPREAD**2 * (count - 1))
    factors = np.arange(count, count + len(FACTORS))
    prior[factors, factors] = 1.0 / np.square(FACTOR_SPREAD)
    shares = np.arange(count + len(FACTORS), size, len(BEGINNING))
    prior[shares, shares] = SHARE_SPREAD**-2
    return prior
