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
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bdt_twin.innovation_filter import STATES, compiled_gains, compiled_innovations

FloatArray = NDArray[np.float64]


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


class DeviationModel:
    """The system that noise drives, over one window.

    Parameters
    ----------
    step : array_like, shape (4, 6)
        The structure's model from block to block.
    block_time : float
        Duration of a block [s].
    motions : sequence of Motion
        One for each stretch.

    Attributes
    ----------
    step : ndarray, shape (4, 6)
        The structure's model.
    block_time : float
        Duration of a block [s].
    begins, contact : ndarray, shape (blocks,)
        One where a stretch begins, and where the motor moves the screw; else zero.
    """

    def __init__(self, step: ArrayLike, block_time: float, motions: Sequence[Motion]) -> None:
        self.step, self.block_time = np.array(step), block_time
        self._fast, self._slow, self.contact = (
            np.concatenate(parts) for parts in zip(*motions, strict=True)
        )
        self.begins = np.zeros(self.contact.size)
        self.begins[np.cumsum([0] + [motion.contact.size for motion in motions[:-1]])] = 1.0

    def walk(self, levels: NoiseLevels) -> FloatArray:
        """Return the variance of the motor's walk in each block [m^2]."""
        walk: FloatArray = (
            levels.fast * levels.fast * self._fast + levels.slow * levels.slow * self._slow
        )
        return walk


class Whitening:
    """The filter of one window.

    Parameters
    ----------
    model : DeviationModel
        What the noise drives.
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
    innovations : ndarray, shape (blocks,)
        Innovations of the residual over their standard deviations.
    pushed : ndarray, shape (blocks,)
        One where something pushed a platform, else zero.
    """

    def __init__(
        self,
        model: DeviationModel,
        levels: NoiseLevels,
        residual: FloatArray,
        threshold: float = math.inf,
    ) -> None:
        self._model, self._residual, self._threshold = model, residual, threshold
        count = residual.size
        self._gains = np.empty((count, STATES))
        variances, self.pushed, self.innovations = np.empty(count), np.zeros(count), np.empty(count)
        compiled_gains()(
            model.step,
            model.begins,
            model.contact,
            model.walk(levels),
            residual,
            levels.force * levels.force * model.block_time,
            levels.reading * levels.reading,
            threshold,
            self._gains,
            variances,
            self.pushed,
            self.innovations,
        )
        self.deviations: FloatArray = np.sqrt(variances)
        self.innovations /= self.deviations

    def with_levels(self, levels: NoiseLevels) -> "Whitening":
        """Return the filter of the same residual for other levels."""
        return Whitening(self._model, levels, self._residual, self._threshold)

    def apply(self, rows: FloatArray) -> FloatArray:
        """Return the innovations over their standard deviations.

        Parameters
        ----------
        rows : ndarray, shape (n, blocks)
            Residuals, or slopes of the position, as block means.
        """
        columns, model = np.ascontiguousarray(rows.T), self._model
        found = np.empty(columns.shape)
        compiled_innovations()(model.step, model.begins, model.contact, self._gains, columns, found)
        found /= self.deviations[:, None]
        return found.T
