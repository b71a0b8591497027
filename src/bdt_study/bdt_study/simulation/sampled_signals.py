"""Signals of a scenario at the instants at which the loop asks for them."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from bdt_controller.reference import ReferenceProfile, reference_at
from bdt_plant.gap_profile import GapProfile, gaps_at

FloatArray = NDArray[np.float64]
Signal = float | FloatArray | Callable[[float], float]


def sampled(
    name: str, signal: ReferenceProfile | GapProfile | Signal, count: int, hold: int, rate: float
) -> FloatArray:
    """Return a signal at the samples 0, hold, 2 hold, ...

    Parameters
    ----------
    name : str
        Name of the signal, for messages.
    signal : ReferenceProfile, GapProfile, float, ndarray of shape (count,) or callable
        The signal; a callable takes the time [s].
    count : int
        Number of values.
    hold : int
        Samples from one value to the next.
    rate : float
        Sampling rate [Hz].

    Returns
    -------
    ndarray, shape (count,)
        Read-only where scenarios share it.

    Raises
    ------
    ValueError
        For an array of another length.
    """
    if isinstance(signal, ReferenceProfile | GapProfile):
        return _sampled_law(signal, count, hold, rate)
    if callable(signal):
        return np.array(
            [signal(time) for time in _times(count, hold, rate).tolist()], dtype=np.float64
        )
    if isinstance(signal, float):
        return _constant(signal, count)
    values = np.array(signal, dtype=np.float64)
    if values.ndim == 0:
        return np.full(count, float(values))
    if values.shape != (count,):
        raise ValueError(f"{name} = array of shape {values.shape}: must be ({count},)")
    return values


# Laws are hashable and slow to sample in Python, and the scenarios of a sweep share them.
@lru_cache(maxsize=16)
def _sampled_law(
    law: ReferenceProfile | GapProfile, count: int, hold: int, rate: float
) -> FloatArray:
    times = _times(count, hold, rate)
    if isinstance(law, ReferenceProfile):
        values = np.array([reference_at(law, time) for time in times.tolist()])
    else:
        values = gaps_at(law, times)
    values.flags.writeable = False
    return values


# What a scenario holds constant, those of a sweep often have in common.
@lru_cache(maxsize=16)
def _constant(value: float, count: int) -> FloatArray:
    values = np.full(count, value)
    values.flags.writeable = False
    return values


def _times(count: int, hold: int, rate: float) -> FloatArray:
    # As PlantSimulator: the sample number divided by the rate.
    times: FloatArray = np.arange(0, count * hold, hold) / rate
    return times
