"""The voltage that a motor gets: what telemetry states, offset, and late by the amplifier's lag.

An amplifier that follows its command with a time constant moves the motor as far as one that is
late by that time, but not where the motor turns round, and that is where a gap is told.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.compilation import GIVEN, WRITTEN, compile_loop
from bdt_plant.elementary_functions import float_exponential
from bdt_twin.machine_knowledge import EFFECTS
from bdt_twin.stretch import Stretch
from bdt_twin.unknowns import SMALLEST_LAG

FloatArray = NDArray[np.float64]

PROMPT = np.empty(0)
"""Says that nobody asks what an amplifier does that is not prompt."""


class AppliedVoltage(NamedTuple):
    """Voltage of the motor over a stretch of data.

    Attributes
    ----------
    before : ndarray, shape (m,)
        Means over the samples before the first one [V], as far as they are known.
    voltage : ndarray, shape (n,)
        Means over the samples [V].
    per_lag : ndarray, shape (n,) or (0,)
        By how much they change with the time constant [V/s]; empty where nothing speaks for one.
    """

    before: FloatArray
    voltage: FloatArray
    per_lag: FloatArray


def applied_voltage(stretch: Stretch, effects: FloatArray, sample_time: float) -> AppliedVoltage:
    """Return the voltage that the motor gets.

    Parameters
    ----------
    stretch : Stretch
        Data, with the voltage as commanded.
    effects : ndarray, shape (effects,)
        ``machine_knowledge.EFFECTS``.
    sample_time : float
        Sample time [s].
    """
    effect = dict(zip(EFFECTS, effects.tolist(), strict=True))
    lag, offset = effect["voltage_lag"], effect["voltage_offset"]
    if lag < SMALLEST_LAG:
        return AppliedVoltage(stretch.before + offset, stretch.voltage + offset, PROMPT)
    commanded, first = np.append(stretch.before, stretch.voltage), stretch.before.size
    voltage, per_lag = lagged(commanded, lag, sample_time)
    voltage += offset
    return AppliedVoltage(voltage[:first], voltage[first:], per_lag[first:])


def lagged(commanded: FloatArray, lag: float, sample_time: float) -> tuple[FloatArray, FloatArray]:
    """Return how a voltage follows its command with a time constant: tau du/dt = command - u.

    Parameters
    ----------
    commanded : ndarray, shape (n,)
        Commands [V], each held for a sample time; it has followed the first one before.
    lag : float
        Time constant tau [s]; none if it is below ``SMALLEST_LAG``.
    sample_time : float
        Sample time T [s].

    Returns
    -------
    means : ndarray, shape (n,)
        Mean voltage over each sample [V].
    per_lag : ndarray, shape (n,)
        Their derivative with respect to the time constant [V/s]; at zero that from above.
    """
    left, share, left_slope, share_slope = 0.0, 0.0, 0.0, 1.0 / sample_time
    if lag >= SMALLEST_LAG:
        left = float_exponential(-sample_time / lag)
        share = lag * (1.0 - left) / sample_time
        left_slope = left * sample_time / (lag * lag)
        share_slope = (1.0 - left) / sample_time - left / lag
    means, per_lag = np.empty((2, commanded.size))
    compiled_lag()(commanded, left, share, left_slope, share_slope, means, per_lag)
    return means, per_lag


@cache
def compiled_lag() -> Any:
    """Return the loop over the samples, compiled."""
    numbers = ("float64",) * 4
    return compile_loop(_follow, f"void({', '.join((GIVEN, *numbers, WRITTEN, WRITTEN))})")


COMPILED = (compiled_lag,)
"""What to call before the first data wait."""


def _follow(
    commanded: FloatArray,
    left: float,
    share: float,
    left_slope: float,
    share_slope: float,
    means: FloatArray,
    per_lag: FloatArray,
) -> None:
    voltage, slope = commanded[0], 0.0
    for k in range(commanded.size):
        off = voltage - commanded[k]
        means[k] = commanded[k] + share * off
        per_lag[k] = share * slope + share_slope * off
        slope = left * slope + left_slope * off
        voltage = commanded[k] + left * off
