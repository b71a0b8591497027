"""Innovations of a fit: what each residual says beyond those before it, for a machine with noise.

A machine is never quite its model. Friction that comes and goes moves the motor a little, a push
or a beam that is not straight moves a platform, and the deviation stays in the position from then
on. So the residual of a simulation is not white, and to weigh it as if it were makes a fit sure of
what is not so. Here it is the output of a linear system that is driven by noise:

    m' = m + w                the motor's deviation, a random walk while the motor turns
    b' = m' in contact, b     the screw's deviation: it follows the motor in contact only
    x' = A x + B (b, b') + f  the structure's deviation, with a random force
    r  = x[q3] + v            the residual, with the noise of the reading

A Kalman filter of this system turns the residual, and the slopes of the position as well, into
innovations, which are white. Nothing is filtered but deviations, so the filter is right at once.

References
----------
L. Ljung, System Identification: Theory for the User, 2nd edition, section 7.2 and 4.3.
"""

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.compilation import compile_loop
from bdt_plant.elementary_functions import exponential, logarithm
from bdt_plant.structure import DiscreteStructure
from bdt_twin.fixed_order import mean, total

FloatArray = NDArray[np.float64]

STATES = 6
"""Structure, screw and motor."""
POSITION, SCREW, MOTOR = 2, 4, 5
"""Places of q3, screw and motor in the state."""
USUAL_RATIOS = (5.0, 20.0, 0.5)
"""Levels fast and slow [1/s^0.5] and force [1/s^1.5] over that of the reading to begin with."""
SMALLEST_GAIN = 0.5
"""Gain of log-likelihood for which a level is changed."""
LEVEL_FACTOR = 3.0
"""Factor by which a level is changed in search of the most likely one."""
PRODUCT = 8
"""Values that are multiplied before their logarithm is taken."""
LARGEST_PUSH = 0.1
"""Standard deviation of the velocity that a push gives to a platform [m/s]."""
SMALLEST_NOISE = 1e-11
"""Standard deviation of a block's mean below which nothing is taken for noise [m]."""
FROM_MAD = 1.4826
"""Standard deviation of normal noise over its median absolute deviation."""
HUBER = 3.0
"""Standard deviations beyond which an innovation counts linearly."""


class NoiseLevels(NamedTuple):
    """How much of what is not in the model there is.

    Attributes
    ----------
    reading : float
        Standard deviation of a block's mean of the reading [m].
    fast, slow : float
        Random walk of the screw's position while the motor turns fast, and slowly [m/s^0.5].
    force : float
        Random walk of the velocity of the platforms [m/s^1.5].
    """

    reading: float
    fast: float = 0.0
    slow: float = 0.0
    force: float = 0.0


class Motion(NamedTuple):
    """What the noise of one stretch of data depends on.

    Attributes
    ----------
    fast, slow : ndarray, shape (blocks,)
        Time in each block for which the motor turns fast, and slowly [s].
    contact : ndarray, shape (blocks,)
        One where the motor moves the screw, else zero.
    """

    fast: FloatArray
    slow: FloatArray
    contact: FloatArray


class Whitening:
    """The filter of one window.

    Parameters
    ----------
    step : DiscreteStructure
        The structure's model from block to block.
    block_time : float
        Duration of a block [s].
    motions : sequence of Motion
        One for each stretch.
    levels : NoiseLevels
        Noise.
    residual : ndarray, shape (blocks,)
        Residual in which pushes are looked for [m].
    threshold : float
        Standard deviations beyond which an innovation tells that something pushed a platform:
        from there on its velocities are unknown.

    Attributes
    ----------
    deviations : ndarray, shape (blocks,)
        Standard deviation of each innovation [m].
    pushed : ndarray, shape (blocks,)
        One where something pushed a platform, else zero.
    """

    def __init__(
        self,
        step: DiscreteStructure,
        block_time: float,
        motions: Sequence[Motion],
        levels: NoiseLevels,
        residual: FloatArray,
        threshold: float = math.inf,
    ) -> None:
        self._step = np.array(step)
        self._contact = np.concatenate([motion.contact for motion in motions])
        walk = np.concatenate(
            [
                levels.fast * levels.fast * motion.fast + levels.slow * levels.slow * motion.slow
                for motion in motions
            ]
        )
        self._begins = np.zeros(walk.size)
        starts = np.cumsum([0] + [motion.contact.size for motion in motions[:-1]])
        self._begins[starts] = 1.0
        self._gains = np.empty((walk.size, STATES))
        variances, self.pushed = np.empty(walk.size), np.zeros(walk.size)
        compiled_gains()(
            self._step,
            self._begins,
            self._contact,
            walk,
            residual,
            levels.force * levels.force * block_time,
            levels.reading * levels.reading,
            threshold,
            self._gains,
            variances,
            self.pushed,
        )
        self.deviations: FloatArray = np.sqrt(variances)

    def apply(self, rows: FloatArray) -> FloatArray:
        """Return the innovations over their standard deviations.

        Parameters
        ----------
        rows : ndarray, shape (n, blocks)
            Residuals, or slopes of the position, as block means.
        """
        found = np.empty(rows.shape)
        compiled_innovations()(
            self._step, self._begins, self._contact, self._gains, rows, found
        )
        found /= self.deviations
        return found


class FittedLevels(NamedTuple):
    """Result of a search for the levels of noise.

    Attributes
    ----------
    levels : NoiseLevels
        The most likely ones.
    prediction_error : float
        Geometric mean of the innovations' standard deviations with them [m].
    """

    levels: NoiseLevels
    prediction_error: float


def fitted_levels(
    make: Callable[[NoiseLevels], Whitening],
    residual: FloatArray,
    levels: NoiseLevels,
    most: int,
) -> FittedLevels:
    """Return the levels of noise that make a residual most likely.

    One level after the other is made larger, smaller or nothing, as long as that helps.

    Parameters
    ----------
    make : callable
        Returns the filter for given levels.
    residual : ndarray, shape (blocks,)
        Residual [m].
    levels : NoiseLevels
        Where to begin.
    most : int
        Levels to try at most; of one only their common scale is found.
    """

    def tried(ratios: FloatArray) -> tuple[float, float]:
        """Return the logarithm of the prediction error and the scale of all levels."""
        whitening = make(NoiseLevels(levels.reading, *(levels.reading * ratios).tolist()))
        innovations = whitening.apply(residual[None, :])[0]
        scale = max(robust_deviation(innovations), SMALLEST_NOISE / levels.reading)
        return mean_logarithm(whitening.deviations) + float(logarithm(scale)), scale

    ratios = np.array(levels[1:]) / levels.reading
    best, scale = tried(ratios)
    count, improved = 1, True
    while improved and count < most:
        improved = False
        for which, usual in enumerate(USUAL_RATIOS):
            if ratios[which] == 0.0:
                values = (usual,)
            else:
                values = (0.0, ratios[which] / LEVEL_FACTOR, ratios[which] * LEVEL_FACTOR)
            for value in values:
                if count >= most:
                    break
                trial = ratios.copy()
                trial[which] = value
                found, found_scale = tried(trial)
                count += 1
                if found < best - SMALLEST_GAIN / residual.size:
                    best, scale, ratios, improved = found, found_scale, trial, True
                    break
    reading = max(levels.reading * scale, SMALLEST_NOISE)
    return FittedLevels(NoiseLevels(reading, *(reading * ratios).tolist()), float(exponential(best)))


def mean_logarithm(values: FloatArray) -> float:
    """Return the mean of the logarithms of positive values."""
    # One logarithm of several values' product, which takes a fraction of the time.
    middle = float(np.median(values))
    ratios = np.ones(-(-values.size // PRODUCT) * PRODUCT)
    ratios[: values.size] = values / middle
    products = np.multiply.reduce(ratios.reshape(PRODUCT, -1))
    return float(logarithm(middle)) + total(logarithm(products)) / values.size


def robust_deviation(values: FloatArray) -> float:
    """Return the standard deviation of values whose outliers are brought back."""
    most = HUBER * max(FROM_MAD * float(np.median(np.abs(values))), 1e-300)
    return max(math.sqrt(mean(np.square(np.clip(values, -most, most)))), 1e-300)


@cache
def compiled_gains() -> Any:
    """Return the recursion of the filter's covariance, compiled."""
    given = "Array(float64, 1, 'C', readonly=True)"
    matrix = "Array(float64, 2, 'C', readonly=True)"
    return compile_loop(
        _filter_gains,
        f"void({matrix}, {given}, {given}, {given}, {given}, float64, float64, float64, "
        "Array(float64, 2, 'C'), Array(float64, 1, 'C'), Array(float64, 1, 'C'))",
    )


@cache
def compiled_innovations() -> Any:
    """Return the filter itself, compiled."""
    given = "Array(float64, 1, 'C', readonly=True)"
    matrix = "Array(float64, 2, 'C', readonly=True)"
    return compile_loop(
        _innovations,
        f"void({matrix}, {given}, {given}, {matrix}, Array(float64, 2, 'A', readonly=True), Array(float64, 2, 'C'))",
    )


def _filter_gains(
    step: FloatArray,
    begins: FloatArray,
    contact: FloatArray,
    walk: FloatArray,
    residual: FloatArray,
    force: float,
    reading: float,
    threshold: float,
    gains: FloatArray,
    variances: FloatArray,
    pushed: FloatArray,
) -> None:
    state, expected = np.zeros(6), np.zeros(6)
    covariance, moved = np.zeros((6, 6)), np.zeros((6, 6))
    transition, transposed = np.zeros((6, 6)), np.zeros((6, 6))
    for i in range(4):
        for j in range(4):
            transition[i, j] = step[i, j]
            transposed[j, i] = step[i, j]
    transition[5, 5] = 1.0
    transposed[5, 5] = 1.0
    for k in range(walk.size):
        if begins[k] > 0.0:
            covariance[:] = 0.0
            expected[:] = 0.0
        else:
            held = 1.0 - contact[k]
            for i in range(4):
                transition[i, 4] = step[i, 4] + step[i, 5] * held
                transition[i, 5] = step[i, 5] * contact[k]
                transposed[4, i], transposed[5, i] = transition[i, 4], transition[i, 5]
            transition[4, 4], transition[4, 5] = held, contact[k]
            transposed[4, 4], transposed[5, 4] = held, contact[k]
            # Sums over whole rows, which the processor works on at once.
            moved[:] = 0.0
            for i in range(6):
                for n in range(6):
                    factor = transition[i, n]
                    if factor != 0.0:
                        for j in range(6):
                            moved[i, j] += factor * covariance[n, j]
            covariance[:] = 0.0
            for i in range(6):
                for n in range(6):
                    # The motor's walk acts as the motor's own column does.
                    factor = moved[i, n]
                    if n == 5:
                        factor += transition[i, 5] * walk[k]
                    for j in range(6):
                        covariance[i, j] += factor * transposed[n, j]
            covariance[1, 1] += force
            covariance[3, 3] += force
            for i in range(6):
                total = 0.0
                for n in range(6):
                    total += transition[i, n] * state[n]
                expected[i] = total
        innovation = residual[k] - expected[2]
        variance = max(covariance[2, 2], 0.0) + reading
        if innovation * innovation > threshold * threshold * variance:
            pushed[k] = 1.0
            for i in range(4):
                for j in range(4):
                    covariance[i, j] += LARGEST_PUSH**2 * (
                        step[i, 1] * step[j, 1] + step[i, 3] * step[j, 3]
                    )
            variance = covariance[2, 2] + reading
        variances[k] = variance
        for i in range(6):
            gains[k, i] = covariance[i, 2] / variance
            state[i] = expected[i] + gains[k, i] * innovation
        for i in range(6):
            factor = gains[k, i] * variance
            for j in range(i + 1):
                left = covariance[i, j] - factor * gains[k, j]
                covariance[i, j] = left
                covariance[j, i] = left
        for i in range(6):
            # Rounding may leave less than nothing where next to nothing is unknown.
            covariance[i, i] = max(covariance[i, i], 0.0)


def _innovations(
    step: FloatArray,
    begins: FloatArray,
    contact: FloatArray,
    gains: FloatArray,
    rows: FloatArray,
    found: FloatArray,
) -> None:
    for row in range(len(rows)):
        x0, x1, x2, x3, b, m = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(begins.size):
            if begins[k] > 0.0:
                x0, x1, x2, x3, b, m = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            else:
                after = m if contact[k] > 0.0 else b
                y0 = step[0, 0] * x0 + step[0, 1] * x1 + step[0, 2] * x2 + step[0, 3] * x3
                y1 = step[1, 0] * x0 + step[1, 1] * x1 + step[1, 2] * x2 + step[1, 3] * x3
                y2 = step[2, 0] * x0 + step[2, 1] * x1 + step[2, 2] * x2 + step[2, 3] * x3
                y3 = step[3, 0] * x0 + step[3, 1] * x1 + step[3, 2] * x2 + step[3, 3] * x3
                x0 = y0 + step[0, 4] * b + step[0, 5] * after
                x1 = y1 + step[1, 4] * b + step[1, 5] * after
                x2 = y2 + step[2, 4] * b + step[2, 5] * after
                x3 = y3 + step[3, 4] * b + step[3, 5] * after
                b = after
            innovation = rows[row, k] - x2
            found[row, k] = innovation
            x0 += gains[k, 0] * innovation
            x1 += gains[k, 1] * innovation
            x2 += gains[k, 2] * innovation
            x3 += gains[k, 3] * innovation
            b += gains[k, 4] * innovation
            m += gains[k, 5] * innovation
