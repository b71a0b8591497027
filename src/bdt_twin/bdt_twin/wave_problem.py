"""What waves of the motor's angle explain beside a fit, and by how much they would move its gap.

Cogging is such a wave. For small ones the position depends on the two parts linearly, so for each
number of periods the likelihood tells what they would explain.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bdt_plant.elementary_functions import exponential, logarithm
from bdt_twin.cogging_waves import wave_slopes
from bdt_twin.fit_doubt import doubted_weights
from bdt_twin.fit_result import Fit
from bdt_twin.fixed_order import dot, product, products_of_rows, total, weighted_products
from bdt_twin.information import inverse
from bdt_twin.innovations import NoiseLevels, Whitening
from bdt_twin.machine_knowledge import COGGING, EFFECT_SPREAD
from bdt_twin.model_factors import FACTORS
from bdt_twin.window_model import WindowModel

FloatArray = NDArray[np.float64]

TIGHTNESS = 1.0 / EFFECT_SPREAD[min(COGGING)] ** 2
"""Prior information on each part of a wave [1/V^2]."""


@dataclass(frozen=True, eq=False)
class WaveFits:
    """A wave of each number of periods, fitted by itself beside all that a fit has found.

    Attributes
    ----------
    sines, mixed, cosines : ndarray, shape (waves,)
        Information on the two parts of each wave, a symmetric matrix [1/V^2].
    slopes : ndarray, shape (2, waves)
        Slopes of the log-likelihood at a motor without cogging [1/V].
    moves : ndarray, shape (unknowns, 2, waves)
        By how much each of the fit's unknowns, cogging left out, moves for a volt of each part.
    """

    sines: FloatArray
    mixed: FloatArray
    cosines: FloatArray
    slopes: FloatArray
    moves: FloatArray

    @property
    def gains(self) -> FloatArray:
        """Gain of log-likelihood by the most likely size of each wave, shape (waves,)."""
        sizes, slopes = self._sizes, self.slopes
        gains: FloatArray = 0.5 * (sizes[0] * slopes[0] + sizes[1] * slopes[1])
        return gains

    def doubt(self, weights: FloatArray) -> float:
        """Return how unsure a motor of which cogging is unknown leaves a sum of unknowns.

        Each number of periods is as likely as what it explains, with all sizes that it may have.

        Parameters
        ----------
        weights : ndarray, shape (unknowns,)
            Weight of each unknown in the sum, cogging left out.

        Returns
        -------
        float
            Root mean square by which the sum moves.
        """
        of_sine, of_cosine = (product(part.T, weights) for part in self.moves.transpose(1, 0, 2))
        sizes, determinant = self._sizes, self._determinant
        moved = of_sine * sizes[0] + of_cosine * sizes[1]
        variance = self.cosines * of_sine * of_sine - 2.0 * self.mixed * of_sine * of_cosine
        variance = (variance + self.sines * of_cosine * of_cosine) / determinant
        evidence = self.gains - 0.5 * logarithm(determinant)
        likely = exponential(evidence - evidence.max())
        return math.sqrt(dot(likely, moved * moved + variance) / total(likely))

    @property
    def _sizes(self) -> tuple[FloatArray, FloatArray]:
        """Most likely sizes of both parts [V]."""
        sine, cosine = self.slopes
        return (
            (self.cosines * sine - self.mixed * cosine) / self._determinant,
            (self.sines * cosine - self.mixed * sine) / self._determinant,
        )

    @property
    def _determinant(self) -> FloatArray:
        return self.sines * self.cosines - self.mixed * self.mixed


class WaveProblem:
    """Waves beside the fit of a window, whatever cogging the fit has.

    Parameters
    ----------
    window : WindowModel
        Model and data.
    fit : Fit
        Their fit.
    """

    def __init__(self, window: WindowModel, fit: Fit) -> None:
        self._window, self._fit = window, fit
        self._jacobian = window.jacobian(fit.unknowns, fit.responses)
        self._waves = wave_slopes(window, fit)
        first = window.knots.size + len(FACTORS)
        self._cogging = [first + effect for effect in sorted(COGGING)]
        self._others = np.delete(np.arange(len(self._jacobian)), self._cogging)
        slopes, weights = self._weighted_slopes(fit.whitening, fit.levels)
        # What the prior pulls at, from the step that the fit did not make.
        told = product(slopes, weights * fit.innovations)
        information = weighted_products(slopes, weights) + fit.prior
        self._pulled = (told - product(information, fit.pending))[self._others]

    def fits(self, levels: NoiseLevels) -> WaveFits:
        """Return the fit of each wave where the noise has some levels."""
        fit, others = self._fit, self._others
        whitening = fit.whitening.with_levels(levels)
        slopes, weights = self._weighted_slopes(whitening, levels)
        # As they would be without the cogging that the fit has.
        sizes = fit.unknowns.as_vector()[self._cogging]
        innovations = whitening.innovations + product(slopes[self._cogging].T, sizes)
        slopes = slopes[others]
        information = weighted_products(slopes, weights) + fit.prior[np.ix_(others, others)]
        slope = product(slopes, weights * innovations) - self._pulled
        waves = whitening.apply(self._waves)
        coupling = products_of_rows(slopes, weights * waves)
        moves = -inverse(information, coupling)
        left = product(waves, weights * innovations) + product(moves.T, slope)

        def explained(one: FloatArray, other: FloatArray, by: int, of: int) -> FloatArray:
            """Return the information on two parts that the other unknowns leave."""
            shared = coupling[:, by::2] * moves[:, of::2]
            return product(one * other, weights) + product(shared.T, np.ones(len(shared)))

        sine, cosine = waves[0::2], waves[1::2]
        return WaveFits(
            explained(sine, sine, 0, 0) + TIGHTNESS,
            explained(sine, cosine, 0, 1),
            explained(cosine, cosine, 1, 1) + TIGHTNESS,
            left.reshape(-1, 2).T,
            moves.reshape(len(moves), -1, 2).transpose(0, 2, 1),
        )

    def _weighted_slopes(
        self, whitening: Whitening, levels: NoiseLevels
    ) -> tuple[FloatArray, FloatArray]:
        """Return the slopes of the innovations, and their weights."""
        weights = doubted_weights(whitening.innovations, levels, self._window.block_rate)
        return whitening.apply(self._jacobian), weights
