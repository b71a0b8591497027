"""Search for the levels of a machine's noise: those that make a residual most likely."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.elementary_functions import float_exponential, float_logarithm
from bdt_twin.innovations import NoiseLevels, Whitening
from bdt_twin.robust_sums import bounded_mean_square, mean_logarithm, median

FloatArray = NDArray[np.float64]

USUAL_RATIOS = (5.0, 20.0, 0.5)
"""Levels fast and slow [1/s^0.5] and force [1/s^1.5] over that of the reading to begin with."""
SMALLEST_GAIN = 0.5
"""Gain of log-likelihood for which a level is changed."""
LEVEL_FACTOR = 3.0
"""Factor by which a level is changed in search of the most likely one."""
RESTLESS = 2.0
"""Walk of the motor in a second, over the noise of a reading, that a model may yet explain."""
HARDLY_EXPLAINED = 8.0
"""Walk of the motor in a second, over the noise of a reading, from which on a fit may not have
found the best one yet."""
QUIETER = 12.0
"""Factor by which the motor is thought to walk less once it is explained."""
NOTHING = 0.02
"""Walk of the motor in a second, over the noise of a reading, that is none."""
SMALLEST_NOISE = 1e-9
"""Standard deviation of a block's mean below which nothing is taken for noise [m]."""
FROM_MAD = 1.4826
"""Standard deviation of normal noise over its median absolute deviation."""
EXPLAINED = 2e-5
"""Share of the position's motion below which it does not matter what a model leaves out."""
HUBER = 3.0
"""Standard deviations beyond which an innovation counts linearly."""


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
    least_slow: float = 0.0,
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
    least_slow : float
        Least level of the motor's walk while it turns slowly [m/s^0.5].
    """

    def tried(ratios: FloatArray) -> tuple[float, float]:
        """Return the logarithm of the prediction error and the scale of all levels."""
        whitening = make(NoiseLevels(levels.reading, *(levels.reading * ratios).tolist()))
        scale = max(robust_deviation(whitening.innovations), SMALLEST_NOISE / levels.reading)
        return mean_logarithm(whitening.deviations) + float_logarithm(scale), scale

    least = np.array([0.0, least_slow, 0.0]) / levels.reading
    ratios = np.maximum(np.array(levels[1:]) / levels.reading, least)
    best, scale = tried(ratios)
    count, improved = 1, True
    while improved and count < most:
        improved = False
        for which, usual in enumerate(USUAL_RATIOS):
            level = float(ratios[which])
            values = [0.0, level / LEVEL_FACTOR, level * LEVEL_FACTOR] if level else [usual]
            for value in values:
                if count >= most:
                    break
                trial = ratios.copy()
                trial[which] = max(value, float(least[which]))
                if trial[which] == level:
                    continue
                found, found_scale = tried(trial)
                count += 1
                if found < best - SMALLEST_GAIN / residual.size:
                    best, scale, ratios, improved = found, found_scale, trial, True
                    break
    reading = max(levels.reading * scale, SMALLEST_NOISE)
    fast, slow, force = (reading * ratios).tolist()
    levels = NoiseLevels(reading, fast, max(slow, least_slow), force)
    return FittedLevels(levels, float_exponential(best))


def motor_walk(levels: NoiseLevels) -> float:
    """Return the random walk of the screw's position where the motor walks most [m/s^0.5].

    Parameters
    ----------
    levels : NoiseLevels
        Levels of noise.
    """
    return max(levels.fast, levels.slow)


def is_restless(levels: NoiseLevels, ratio: float = RESTLESS) -> bool:
    """Tell whether the motor walks so much that something may be left to be explained.

    Parameters
    ----------
    levels : NoiseLevels
        Levels of noise.
    ratio : float
        Walk of the motor in a second, over the noise of a reading, that is not much.
    """
    return motor_walk(levels) > ratio * levels.reading


def is_slight(levels: NoiseLevels) -> bool:
    """Tell whether a motor that is made :func:`quiet` would not walk at all."""
    return not any(quiet(levels)[1:3])


def is_noticed(levels: NoiseLevels) -> bool:
    """Tell whether there is noise of the machine beside that of the reading."""
    return levels.force > 0.0 or is_restless(levels, NOTHING)


def is_walking(levels: NoiseLevels, motion: float) -> bool:
    """Tell whether the motor's walk hides what a model leaves out that is nearly exact.

    Parameters
    ----------
    levels : NoiseLevels
        Levels of noise.
    motion : float
        Standard deviation of the position [m].
    """
    return is_restless(levels) and motor_walk(levels) > EXPLAINED * motion


def quiet(levels: NoiseLevels) -> NoiseLevels:
    """Return levels for a motor that walks less, as it does once the model explains it."""
    fast, slow = (
        level / QUIETER if level > QUIETER * NOTHING * levels.reading else 0.0
        for level in (levels.fast, levels.slow)
    )
    return levels._replace(fast=fast, slow=slow)


def absolute_deviation(values: FloatArray) -> float:
    """Return the standard deviation of normal values around zero, by their median size."""
    return FROM_MAD * median(np.abs(values))


def robust_deviation(values: FloatArray) -> float:
    """Return the standard deviation of values whose outliers are brought back."""
    most = HUBER * max(absolute_deviation(values), 1e-300)
    return max(math.sqrt(bounded_mean_square(values, most)), 1e-300)
