"""A position sensor at the end of its range."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SHORTEST_SATURATION = 20
"""Equal samples in a row from which on the position counts as stuck."""


def motor_travel_in_saturation(voltage: FloatArray, position: FloatArray, gain: float) -> float:
    """Return how far the motor turned at most while the position stood at its extreme [rad].

    A platform at rest shows the same position for long, be it the largest one of all; but a
    motor that turns by more than the gap moves it.

    Parameters
    ----------
    voltage, position : ndarray, shape (n,)
        Motor voltage u [V] and position q3 [m].
    gain : float
        Angle by which the motor turns per sample and volt [rad/V].
    """
    turned = 0.0
    angle = gain * np.concatenate([[0.0], np.cumsum(voltage[:-1])])
    for extreme in (position.min(), position.max()):
        # The ends of runs are where being at the extreme changes.
        at = np.concatenate([[False], position == extreme, [False]])
        edges = np.flatnonzero(at[1:] != at[:-1]).reshape(-1, 2)
        for first, end in edges[edges[:, 1] - edges[:, 0] >= SHORTEST_SATURATION]:
            turned = max(turned, float(np.ptp(angle[first:end])))
    return turned
