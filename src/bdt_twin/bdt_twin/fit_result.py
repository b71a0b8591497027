"""What the fit of a window has found."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bdt_twin.forward_model import StretchResponse
from bdt_twin.innovations import NoiseLevels, Whitening
from bdt_twin.machine_knowledge import MachineKnowledge
from bdt_twin.noise_levels import EXPLAINED
from bdt_twin.unknowns import Unknowns

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Fit:
    """Result of a fit.

    Attributes
    ----------
    unknowns : Unknowns
        Where the fit ended.
    responses : list of StretchResponse
        The simulation there.
    residual : float
        Standard deviation of the residual's block means, without outliers [m].
    prediction_error : float
        Geometric mean of the standard deviations of the innovations [m].
    levels : NoiseLevels
        What of the residual is noise of the reading, and what of the machine.
    prior : ndarray, shape (unknowns, unknowns)
        Inverse covariance of the unknowns before any data.
    covariance : ndarray, shape (unknowns, unknowns)
        Covariance of the unknowns.
    pending : ndarray, shape (unknowns,)
        The step that the fit did not make, because it was at its end, or because no part of it
        made the fit better.
    simulated : int
        Samples simulated until there was this fit, for those that were left, too.
    whitening : Whitening
        The filter that makes innovations of the residual.
    evidence : ndarray, shape (effects,)
        Gain of log-likelihood by each of ``EFFECTS`` that the machine is thought not to have.
    """

    unknowns: Unknowns
    responses: list[StretchResponse]
    residual: float
    prediction_error: float
    levels: NoiseLevels
    prior: FloatArray
    covariance: FloatArray
    pending: FloatArray
    simulated: int
    whitening: Whitening
    evidence: FloatArray

    @property
    def innovations(self) -> FloatArray:
        """Innovations over their standard deviations, shape (blocks,)."""
        return self.whitening.innovations

    @property
    def pushed(self) -> FloatArray:
        """One where something pushed a platform, else zero, shape (blocks,)."""
        return self.whitening.pushed

    def gain_over(self, other: "Fit") -> float:
        """Return the gain of log-likelihood over another fit of the same data.

        Parameters
        ----------
        other : Fit
            The other one.
        """
        return self.innovations.size * math.log(other.prediction_error / self.prediction_error)

    def negligible(self, motion: float) -> float:
        """Return the size of innovations that is as good as none, however small the noise is.

        Parameters
        ----------
        motion : float
            Standard deviation of the position [m].
        """
        return EXPLAINED * motion / self.prediction_error

    @property
    def gap_covariance(self) -> FloatArray:
        """Covariance of the gap at the knots [rad^2], shape (knots, knots)."""
        knots = self.unknowns.gaps.size
        return self.covariance[:knots, :knots]

    @property
    def machine(self) -> MachineKnowledge:
        """What the window has told about the machine."""
        known = np.concatenate([self.unknowns.factors, self.unknowns.effects])
        first = self.unknowns.gaps.size
        last = first + known.size
        return MachineKnowledge(known, self.covariance[first:last, first:last])
