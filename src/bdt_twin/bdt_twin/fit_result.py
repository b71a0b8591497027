"""What the fit of a window has found."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bdt_twin.forward_model import StretchResponse
from bdt_twin.innovations import NoiseLevels, Whitening
from bdt_twin.linearization import Linearization
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
    simulated : int
        Samples simulated until there was this fit, for those that were left, too.
    whitening : Whitening
        The filter that makes innovations of the residual.
    around : Linearization
        The problem around the end of the fit.
    """

    unknowns: Unknowns
    responses: list[StretchResponse]
    residual: float
    prediction_error: float
    levels: NoiseLevels
    simulated: int
    whitening: Whitening
    around: Linearization

    @property
    def prior(self) -> FloatArray:
        """Inverse covariance of the unknowns before any data, shape (unknowns, unknowns)."""
        return self.around.slopes.prior

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the unknowns, shape (unknowns, unknowns)."""
        return self.around.covariance

    @property
    def pending(self) -> FloatArray:
        """The step that was not made, because the fit was at its end or no part of it helped."""
        return self.around.pending

    @property
    def evidence(self) -> FloatArray:
        """Gain of log-likelihood by each of ``EFFECTS`` that the machine is thought not to have."""
        return self.around.evidence

    def with_covariance(self, covariance: FloatArray) -> "Fit":
        """Return the fit with another covariance of the unknowns, shape (unknowns, unknowns)."""
        return replace(self, around=self.around.with_covariance(covariance))

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
