"""Nonlinear least squares of the forward model over one window."""

import math
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.elementary_functions import logarithm
from bdt_twin.block_residual import BlockResidual
from bdt_twin.cramer_rao import fisher_information
from bdt_twin.fit_doubt import doubted_weights, huber_weights
from bdt_twin.fit_result import Fit
from bdt_twin.fixed_order import dot, mean, product, total, weighted_products
from bdt_twin.forward_model import StretchResponse
from bdt_twin.information import solved
from bdt_twin.innovations import DeviationModel, NoiseLevels, Whitening
from bdt_twin.linearization import Linearization, Slopes
from bdt_twin.machine_knowledge import MachineKnowledge
from bdt_twin.model_factors import FACTORS
from bdt_twin.noise_levels import (
    HUBER,
    SMALLEST_NOISE,
    FittedLevels,
    absolute_deviation,
    fitted_levels,
    is_walking,
    robust_deviation,
)
from bdt_twin.robust_sums import huber_loss
from bdt_twin.unknowns import Unknowns
from bdt_twin.window_model import WindowModel
from bdt_twin.window_prior import prior_precision

FloatArray = NDArray[np.float64]

PUSHED = 6.0
"""Standard deviations of an innovation beyond which something pushed a platform."""


CHANGE_FREEDOM = 2.0
"""Degrees of freedom of Student's distribution, of which growth changes are: few are large."""

MOST_LEVELS = 8
"""Levels of noise to try at the end of a fit."""
FRICTION_VARIATION = 3e-4
"""Share of its friction by which a motor's friction differs from second to second [s^0.5]."""
MOST_SEARCHES = 3
"""Searches for levels of noise at the end of a fit."""
LEVELS_AGREE = 0.998
"""Ratio of prediction errors from which on other levels of noise are not worth another step."""
TOO_SMALL = 2.0
"""Standard deviation of the innovations from which on the levels are made larger at first."""
HALVINGS = 3
"""Halvings of a step that makes the fit worse, before the fit ends."""
SMALLEST_GAIN = 0.1
"""Gain of log-likelihood by a step that ends the fit; a half is one standard deviation."""


class _Point(NamedTuple):
    """Unknowns with their simulation, their residual and what noise does to it."""

    unknowns: Unknowns
    responses: list[StretchResponse]
    residual: FloatArray
    deviation: DeviationModel

    def whitening(self, levels: NoiseLevels, threshold: float = math.inf) -> Whitening:
        """Return the filter of the residual."""
        return Whitening(self.deviation, levels, self.residual, threshold)


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
    machine : MachineKnowledge
        What is known of the machine before.
    """

    def __init__(
        self, window: WindowModel, growth_change: float, machine: MachineKnowledge
    ) -> None:
        self._window = window
        self._residual = BlockResidual(window.stretches, window.block)
        self._prior = prior_precision(window.knots, len(window.stretches), machine)
        self._expected = np.zeros(len(self._prior))
        self._expected[window.knots.size :][: machine.expected.size] = machine.expected
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
        levels: NoiseLevels | None = None,
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
        levels : NoiseLevels, optional
            Noise of the machine to begin with; None for a fit that is to be near, no more, for
            which all that is not explained is noise of the reading.
        patience : int
            Simulations after which the fit ends if its prediction error is larger than `enough`.
        enough : float
            Prediction error [m].
        """
        point, simulated, searches, error = self._at(unknowns), 1, 0, math.inf
        for number in range(1, steps + 1):
            if simulated >= simulations:
                break
            settled = _noise(point.residual)
            noise = settled
            if levels is None:
                # A model that is still wrong is wrong in the transients only, which are no
                # outliers.
                noise = max(settled, math.sqrt(mean(np.square(point.residual))) / 2**number)
                whitening = point.whitening(NoiseLevels(noise))
            else:
                if number == 1:
                    levels = _unpushed_levels(point, levels)
                # A machine without noise so far is given the chance that the gap explains all.
                is_noisy = number == 1 and any(levels[1:])
                levels, error = self._levels(point, levels, MOST_LEVELS if is_noisy else 1)
                if simulated >= patience and error > enough:
                    break
                whitening = point.whitening(levels, PUSHED)
            before, most = self._cost(point, whitening.innovations), simulations - simulated
            trial, after, tried = self._descend(point, whitening, before, min(1 + HALVINGS, most))
            simulated += tried
            if after <= before:
                point = trial
            if after > before or (
                noise < 1.2 * settled and before - after < SMALLEST_GAIN + 1e-4 * before
            ):
                if levels is None:
                    break
                # Other levels of noise have another best fit.
                levels, settled_error = self._levels(point, levels, MOST_LEVELS)
                searches += 1
                if searches == MOST_SEARCHES or settled_error > LEVELS_AGREE * error:
                    break
        return self._result(point, simulated, levels)

    def _descend(
        self, point: _Point, whitening: Whitening, before: float, most: int
    ) -> tuple[_Point, float, int]:
        """Return the last point tried on the way of a step, its cost, and how many were tried.

        The step is halved until the cost is no larger than `before`, or `most` points were tried.
        """
        step, vector, tried = self._step(point, whitening), point.unknowns.as_vector(), 0
        while True:
            trial = self._at(point.unknowns.from_vector(vector + 0.5**tried * step))
            after = self._cost(trial, whitening.apply(trial.residual[None, :])[0])
            tried += 1
            if after <= before or tried == most:
                return trial, after, tried

    def _at(self, unknowns: Unknowns) -> _Point:
        responses = self._window.simulate(unknowns)
        residual = self._residual.means([run.position for run in responses])
        deviation = self._window.deviation_model(unknowns, responses)
        return _Point(unknowns, responses, residual, deviation)

    def _levels(self, point: _Point, levels: NoiseLevels, most: int) -> FittedLevels:
        variation = FRICTION_VARIATION * point.unknowns.friction
        return fitted_levels(
            lambda tried: point.whitening(tried, PUSHED),
            point.residual,
            levels,
            most,
            variation * self._window.travel_per_volt(point.unknowns),
        )

    def _step(self, point: _Point, whitening: Whitening) -> FloatArray:
        """Return Gauss and Newton's step."""
        jacobian = whitening.apply(self._window.jacobian(point.unknowns, point.responses))
        weights = huber_weights(whitening.innovations)
        information = fisher_information(jacobian, weights) + self._prior_at(point.unknowns)
        return solved(information, self._gradient(point, jacobian, weights * whitening.innovations))

    def _gradient(self, point: _Point, jacobian: FloatArray, innovations: FloatArray) -> FloatArray:
        """Return the slope of the log-likelihood with respect to the unknowns."""
        off = point.unknowns.as_vector() - self._expected
        gradient: FloatArray = product(jacobian, innovations)
        return gradient - product(self._prior_at(point.unknowns), off)

    def _cost(self, point: _Point, innovations: FloatArray) -> float:
        """Return the negative log-likelihood of unknowns and data, but for a constant."""
        vector = point.unknowns.as_vector() - self._expected
        changes = product(self._changes, point.unknowns.gaps)
        rare = 0.5 * (CHANGE_FREEDOM + 1.0) * logarithm(1.0 + np.square(changes) / CHANGE_FREEDOM)
        return (
            huber_loss(innovations, HUBER)
            + total(rare)
            + 0.5 * dot(vector, product(self._prior, vector))
        )

    def _prior_at(self, unknowns: Unknowns) -> FloatArray:
        """Return the inverse covariance of the unknowns before any data."""
        changes, count = product(self._changes, unknowns.gaps), unknowns.gaps.size
        weights = (CHANGE_FREEDOM + 1.0) / (CHANGE_FREEDOM + np.square(changes))
        prior = self._prior.copy()
        prior[:count, :count] += weighted_products(self._changes.T, weights)
        return prior

    def _result(self, point: _Point, simulations: int, levels: NoiseLevels | None) -> Fit:
        residual = max(SMALLEST_NOISE, robust_deviation(point.residual))
        if levels is None:
            levels, error = NoiseLevels(residual), residual
            whitening = point.whitening(levels)
        else:
            # A walk that the search had no time for makes a wrong answer sure.
            walks = is_walking(levels, self._window.motion)
            levels, error = self._levels(point, levels, MOST_LEVELS if walks else 1)
            whitening = point.whitening(levels, PUSHED)
        return Fit(
            point.unknowns,
            point.responses,
            residual,
            error,
            levels,
            simulations * self._window.samples,
            whitening,
            Linearization(
                partial(self._slopes, point, whitening, levels),
                point.unknowns.gaps.size + len(FACTORS),
            ),
        )

    def _slopes(self, point: _Point, whitening: Whitening, levels: NoiseLevels) -> Slopes:
        """Return the slopes of the log-likelihood at the end of a fit."""
        jacobian = whitening.apply(self._window.jacobian(point.unknowns, point.responses))
        innovations = whitening.innovations
        weights = doubted_weights(innovations, levels, self._window.block_rate)
        told, prior = fisher_information(jacobian, weights), self._prior_at(point.unknowns)
        return Slopes(told, prior, self._gradient(point, jacobian, weights * innovations))


def _unpushed_levels(point: _Point, levels: NoiseLevels) -> NoiseLevels:
    """Return the levels as large as most of the innovations are if nothing pushed a platform.

    With levels that are far too small nearly all innovations would be pushes.
    """
    scale = absolute_deviation(point.whitening(levels).innovations)
    return NoiseLevels(*(scale * np.array(levels)).tolist()) if scale > TOO_SMALL else levels


def _noise(residual: FloatArray) -> float:
    """Return the standard deviation of a residual, whatever the outliers [m]."""
    return max(SMALLEST_NOISE, absolute_deviation(residual))
