"""Bases of the structure for the slopes with respect to the gap at the knots."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def play_bases(
    knots: FloatArray,
    times: FloatArray,
    side: FloatArray,
    pitch: float,
    initial: FloatArray,
    share: float,
) -> FloatArray:
    """Return how far the gap at each knot moves the screw's end, for a unit of it (eq. 6).

    Parameters
    ----------
    knots : ndarray, shape (knots,)
        Times of the gap's knots, evenly spaced [s].
    times : ndarray, shape (blocks,)
        Mean time of the last contact in each block [s].
    side : ndarray, shape (blocks,)
        Mean direction of the screw's last motion; see ``StretchResponse.side``.
    pitch : float
        Travel of the screw per angle [m/rad].
    initial : ndarray, shape (knots,)
        By how much the gap at the beginning depends on that at each knot.
    share : float
        Where in the gap the motor was then, from -1 to 1.

    Returns
    -------
    ndarray, shape (blocks, knots)
        In [m/rad].
    """
    bases = np.zeros((times.size, knots.size))
    places = (times - knots[0]) / (knots[1] - knots[0])
    before = np.minimum(places.astype(np.int64), knots.size - 2)
    per_gap, blocks = -0.5 * pitch * side, np.arange(times.size)
    later = per_gap * (places - before)
    bases[blocks, before], bases[blocks, before + 1] = per_gap - later, later
    for knot in np.flatnonzero(initial).tolist():
        bases[:, knot] += 0.5 * pitch * share * initial[knot] * np.abs(side)
    return bases
