"""The error of a screw's thread: its travel is off by a wave of the screw's angle, one per turn."""

import numpy as np
from numpy.typing import NDArray

from bdt_plant.elementary_functions import FULL_TURN
from bdt_twin.cog_wave import cog_waves
from bdt_twin.structure_responses import structure_responses

FloatArray = NDArray[np.float64]


def thread_waves(screw: FloatArray, turns: float) -> FloatArray:
    """Return how far a unit of each part of the error moves the screw's end, shape (blocks, 2).

    Parameters
    ----------
    screw : ndarray, shape (blocks,)
        Angle of the screw since a stretch began [rad].
    turns : float
        How often it had turned then; the error there is part of the reading's offset.
    """
    waves = cog_waves(np.append(screw / FULL_TURN, 0.0) + turns)
    since: FloatArray = waves[:-1] - waves[-1]
    return since


def thread_response(
    step: FloatArray, screw: FloatArray, turns: float, sizes: FloatArray, block: int
) -> FloatArray:
    """Return how far the error moves platform 3 (eq. 3), the same in all samples of a block.

    Parameters
    ----------
    step : ndarray, shape (4, 6)
        Discrete structure whose sample is a block.
    screw, turns
        See :func:`thread_waves`.
    sizes : ndarray, shape (2,)
        Parts of the error, a sine and a cosine [m].
    block : int
        Samples in a block.

    Returns
    -------
    ndarray, shape (blocks * block,)
    """
    waves = thread_waves(screw, turns)
    base = sizes[0] * waves[:, 0] + sizes[1] * waves[:, 1]
    moved: FloatArray = np.repeat(structure_responses(step, base[:, None])[:, 0], block)
    return moved
