"""The wave of the motor's cogging, from a table: it is asked for several times in each sample."""

import math

import numpy as np
from numpy.typing import NDArray

from bdt_plant.elementary_functions import sine_of_turns

FloatArray = NDArray[np.float64]

VALUES_PER_TURN = 1024
"""Values of the sine that are known for each period; a multiple of four."""
QUARTER = VALUES_PER_TURN // 4
SINES = np.array(
    [sine_of_turns(number / VALUES_PER_TURN) for number in range(VALUES_PER_TURN + QUARTER + 2)]
)
"""The sine over a period and a quarter; the line between two values is off by 5e-6."""


def cog_wave(turns: float) -> tuple[float, float]:
    """Return sine and cosine of an angle in full turns, right to 5e-6; a step function."""
    place = (turns - math.floor(turns)) * VALUES_PER_TURN
    # What is just below a whole turn may be rounded to one.
    number = int(place)
    part, ahead = place - number, number + QUARTER
    sine, cosine = float(SINES[number]), float(SINES[ahead])
    return (
        sine + part * (float(SINES[number + 1]) - sine),
        cosine + part * (float(SINES[ahead + 1]) - cosine),
    )


def cog_waves(turns: FloatArray) -> FloatArray:
    """Return :func:`cog_wave` of many angles, shape (n,), as an array of shape (n, 2)."""
    places = (turns - np.floor(turns)) * VALUES_PER_TURN
    numbers = places.astype(np.int64)
    found = np.empty((turns.size, 2))
    for part, first in enumerate((numbers, numbers + QUARTER)):
        found[:, part] = SINES[first] + (places - numbers) * (SINES[first + 1] - SINES[first])
    return found
