"""Nonlinear least squares of the forward model over one window."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_twin.forward_model import WindowRun
from bdt_twin.window_model import BEGINNING, FACTORS, Unknowns, WindowModel

FloatArray = NDArray[np.float64]

SMALLEST_NOISE = 1e-9
"""Standard deviation of a block's mean below which nothing is taken for noise [m]."""
FROM_MAD = 1.4826
"""Standard deviation of normal noise over its median absolute deviation."""
HUBER = 3.0
"""Standard deviations beyond which the residual of a block counts linearly."""
FACTOR_SPREAD = (0.3, 0.2, 0.7)
"""Prior standard deviations of the logarithms of ``FACTORS``."""
PATIENCE = 4
"""Halvings of a step that makes the fit worse."""


@dataclass(frozen=True, eq=False)
class Fit:
    """Result of a fit.

    Attributes
    ----------
    unknowns : Unknowns
        Where the fit ended.
    runs : list of WindowRun
        The simulation there.
    residual : ndarray, shape (blocks,)
        Mean measured less simulated position [m]; zero where a block has no sample to use.
    noise : float
        Standard deviation of the residual, robust [m].
    correlation : float
        Blocks that the residual takes to change: by how much its mean is less sure than that of
        white noise.
    information : ndarray, shape (unknowns, unknowns)
        Inverse covariance of the unknowns, prior included.
    cost : float
        Mean Huber loss per block [m^2].
    iterations : int
        Steps taken.
    """

    unknowns: Unknowns
    runs: list[WindowRun]
    residual: FloatArray
    noise: float
    correlation: float
    information: FloatArray
    cost: float
    iterations: int


class _Point(NamedTuple):
    unknowns: Unknowns
    runs: list[WindowRun]
    residual: FloatArray


class WindowFit:
    def __init__(self, window: WindowModel, growth_change: float) -> None:
        self._window = window
        self._means = _BlockMeans(window)
        knots = window.knots
        self._prior = _gap_prior(knots, growth_change)

    def solve(self, unknowns: Unknowns, iterations: int, tolerance: float = 0.02) -> Fit:
        point = self._at(unknowns)
        noise = math.inf
        for iteration in range(1, iterations + 1):
            slopes = self._window.slopes(point.unknowns, point.runs)
            settled = max(SMALLEST_NOISE, FROM_MAD * float(np.median(np.abs(point.residual))))
            rms = float(np.sqrt(np.mean(point.residual**2)))
            noise = max(settled, rms / 2**iteration)
            weights = self._weights(point.residual, noise)
            prior, pull = self._prior_at(point.unknowns)
            information = _product(slopes, weights / noise**2) + prior
            gradient = np.einsum("ik,k->i", slopes, weights * point.residual / noise**2) + pull
            step = _solve(information, gradient)
            before = self._cost(point, noise)
            after = before
            vector = point.unknowns.as_vector()
            for _ in range(PATIENCE):
                trial = self._at(point.unknowns.from_vector(vector + step))
                after = self._cost(trial, noise)
                if after <= before * (1 + 1e-9):
                    break
                step = 0.5 * step
            else:
                break
            point = trial
            if noise <= 1.2 * settled and before - after < tolerance * (1.0 + 1e-4 * before):
                break
        return self._finish(point, iteration)

    def _finish(self, point, iteration):
        slopes = self._window.slopes(point.unknowns, point.runs)
        noise = max(SMALLEST_NOISE, FROM_MAD * float(np.median(np.abs(point.residual))))
        weights = self._weights(point.residual, noise)
        prior, _ = self._prior_at(point.unknowns)
        bounded = np.clip(point.residual, -HUBER * noise, HUBER * noise)
        spread = float(np.mean(bounded**2))
        correlation = _correlation(bounded)
        information = (
            _product(slopes, weights / (max(spread, SMALLEST_NOISE**2) * correlation)) + prior
        )
        return Fit(
            point.unknowns,
            point.runs,
            point.residual,
            math.sqrt(spread),
            correlation,
            information,
            self._loss(point.residual, noise).mean() * noise**2,
            iteration,
        )

    def _at(self, unknowns: Unknowns) -> _Point:
        runs = self._window.run(unknowns)
        return _Point(unknowns, runs, self._means.residual(runs))

    def _loss(self, residual, noise):
        size = np.abs(residual) / noise
        return np.where(size <= HUBER, 0.5 * size**2, HUBER * (size - 0.5 * HUBER))

    def _weights(self, residual, noise):
        size = np.abs(residual) / noise
        return self._means.used * np.minimum(1.0, HUBER / np.maximum(size, HUBER))

    def _cost(self, point: _Point, noise: float) -> float:
        vector = point.unknowns.as_vector()
        information, _ = self._prior_at(point.unknowns)
        centre = self._centre(point.unknowns)
        off = vector - centre
        return float(self._loss(point.residual, noise).sum() + 0.5 * off @ information @ off)

    def _centre(self, unknowns):
        return np.zeros(unknowns.as_vector().size)

    def _prior_at(self, unknowns: Unknowns):
        size, knots = unknowns.as_vector().size, unknowns.gaps.size
        prior = np.zeros((size, size))
        prior[:knots, :knots] = self._prior
        for n, s in enumerate(FACTOR_SPREAD):
            prior[knots + n, knots + n] = s**-2
        for n in range(unknowns.beginnings.shape[0]):
            i = knots + len(FACTORS) + len(BEGINNING) * n
            prior[i, i] = 1.0
        return prior, -prior @ unknowns.as_vector()


class _BlockMeans:
    def __init__(self, window: WindowModel) -> None:
        self._window = window
        self._good: list[FloatArray] | None = None
        self.used = 1.0

    def residual(self, runs):
        block = self._window.block
        full = [
            (s.position - r.position).reshape(-1, block)
            for s, r in zip(self._window.stretches, runs, strict=True)
        ]
        if self._good is None:
            self._good = [_good(f) for f in full]
            counts = np.concatenate([g.sum(axis=1) for g in self._good])
            self.used = (counts >= 0.5 * block).astype(float)
            self._scale = self.used / np.maximum(counts, 1)
            self._all = all(g.all() for g in self._good)
        if self._all:
            return np.concatenate([f.mean(axis=1) for f in full])
        sums = np.concatenate(
            [np.einsum("ij,ij->i", f, g) for f, g in zip(full, self._good, strict=True)]
        )
        return sums * self._scale


def _good(residual):
    if residual.shape[1] < 5:
        return np.ones(residual.shape)
    middle = np.median(residual, axis=1, keepdims=True)
    off = np.abs(residual - middle)
    spread = np.median(off, axis=1, keepdims=True)
    steps = np.abs(np.diff(residual.ravel()))
    return (off <= 12 * np.maximum(spread, spread.mean()) + 1e-12).astype(float)


def _gap_prior(knots, growth_change):
    n, spacing = knots.size, knots[1] - knots[0]
    prior = np.eye(n) * 10.0**-2
    first = np.diff(np.eye(n), axis=0) / spacing
    prior += first.T @ first * math.radians(10.0) ** -2 / n
    second = np.diff(first, axis=0)
    prior += second.T @ second / (growth_change**2 * spacing)
    return prior


def _solve(information, gradient):
    scale = 1 / np.sqrt(np.diag(information))
    scaled = information * np.outer(scale, scale)
    scaled += 1e-12 * np.eye(scale.size)
    return scale * np.linalg.solve(scaled, scale * gradient)


def _correlation(residual, longest=200):
    n = residual.size
    longest = min(longest, n // 4)
    r = residual - 0
    size = 1 << (2 * n - 1).bit_length()
    spectrum = np.abs(np.fft.rfft(r, size)) ** 2
    cov = np.fft.irfft(spectrum, size)[: longest + 1]
    if cov[0] <= 0:
        return 1.0
    rho = cov[1:] / cov[0]
    w = 1 - np.arange(1, longest + 1) / (longest + 1)
    return max(1.0, 1 + 2 * float(w @ rho))


def _product(slopes: FloatArray, weights: FloatArray) -> FloatArray:
    """Return slopes diag(weights) slopes^T."""
    # BLAS would wake threads, which on a busy computer wait longer for each other than they work.
    product: FloatArray = np.einsum("ik,jk->ij", slopes * weights, slopes)
    return product
