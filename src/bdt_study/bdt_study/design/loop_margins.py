"""Margins of a loop: crossovers, phase and gain margins, sensitivity, bandwidth."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from control import StateSpace
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar

from bdt_study.design.linear_model import closed_loop_poles, frequency_response, is_stable

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

HALF_POWER = math.sqrt(0.5)


@dataclass(frozen=True)
class Crossover:
    """A frequency at which ``|L| = 1``.

    Attributes
    ----------
    frequency : float
        Angular frequency [rad/s].
    phase_margin : float
        Phase of L plus 180 degrees, within +-pi [rad]: what L may lag more (positive) or lead more
        (negative) before it meets -1 here.
    """

    frequency: float
    phase_margin: float


@dataclass(frozen=True)
class LoopMargins:
    """How far a loop is from instability, and how fast it is.

    Attributes
    ----------
    stable : bool
        Whether the closed loop is asymptotically stable; without that the rest means nothing.
    crossovers : tuple of Crossover
        All gain crossovers, in the order of frequency.
    gain_margin : float
        Factor nearest to 1 (in decibels) by which L may be multiplied before it meets -1; below 1
        when less gain is the danger, infinite without a phase crossover.
    maximum_sensitivity : float
        M_s, the maximum of ``|S| = 1 / |1 + L|``: 1 over the distance of the Nyquist curve from -1.
    sensitivity_frequency : float
        Where that maximum is [rad/s].
    bandwidth : float
        Frequency at which ``|T|`` falls below -3 dB for the first time [rad/s].
    """

    stable: bool
    crossovers: tuple[Crossover, ...]
    gain_margin: float
    maximum_sensitivity: float
    sensitivity_frequency: float
    bandwidth: float

    @property
    def first_crossover(self) -> float:
        """Lowest gain crossover [rad/s]; the bandwidth frequency that the design sets."""
        return self.crossovers[0].frequency if self.crossovers else math.nan

    @property
    def smallest_phase_margin(self) -> float:
        """Smallest magnitude of the phase margins over all crossovers [rad]."""
        return min((abs(each.phase_margin) for each in self.crossovers), default=math.inf)


def loop_margins(loop: StateSpace) -> LoopMargins:
    """Return the margins of a loop.

    Parameters
    ----------
    loop : control.StateSpace
        L, with one input and one output, in continuous or discrete time.
    """
    frequency = characteristic_frequencies(loop)
    values = frequency_response(loop, frequency)

    def value(at: float) -> complex:
        return complex(frequency_response(loop, np.array([at]))[0])

    def roots(function: Callable[[ComplexArray], FloatArray]) -> list[float]:
        """Return where a function of L changes its sign [rad/s], in order."""
        positive = function(values) > 0
        return [
            float(
                brentq(
                    lambda at: function(np.array([value(at)]))[0],
                    frequency[k],
                    frequency[k + 1],
                    xtol=1e-10,
                )
            )
            for k in np.flatnonzero(positive[1:] != positive[:-1])
        ]

    crossovers = tuple(
        Crossover(at, float(np.angle(-value(at)))) for at in roots(lambda each: np.abs(each) - 1.0)
    )
    turns = [value(at).real for at in roots(lambda each: each.imag)]
    factors = [-1.0 / real for real in turns if real < 0]
    nearest = int(np.argmin(np.abs(1 + values)))
    around = frequency[max(nearest - 1, 0)], frequency[min(nearest + 1, frequency.size - 1)]
    closest = minimize_scalar(
        lambda at: abs(1 + value(at)), bounds=around, method="bounded", options={"xatol": 1e-9}
    )
    falls = roots(lambda each: np.abs(each / (1 + each)) - HALF_POWER)
    return LoopMargins(
        stable=is_stable(loop),
        crossovers=crossovers,
        gain_margin=min(factors, key=lambda factor: abs(math.log(factor)), default=math.inf),
        maximum_sensitivity=1.0 / float(closest.fun),
        sensitivity_frequency=float(closest.x),
        bandwidth=falls[0] if falls else math.inf,
    )


def characteristic_frequencies(loop: StateSpace, points: int = 3000) -> FloatArray:
    """Return frequencies that resolve every pole of a loop, open and closed.

    Parameters
    ----------
    loop : control.StateSpace
        L, in continuous or discrete time.
    points : int
        Number of logarithmically spaced frequencies, to which those around resonances are added.

    Returns
    -------
    ndarray, shape (n,)
        Increasing angular frequencies [rad/s], below the Nyquist frequency in discrete time.
    """
    poles = np.concatenate([loop.poles(), closed_loop_poles(loop)])
    discrete = loop.isdtime(strict=True)
    if discrete:
        # A pole at z = 0 is a delay and has no frequency of its own.
        poles = np.log(poles[np.abs(poles) > 1e-12].astype(complex)) / loop.dt
    # Integrators are poles at zero up to rounding.
    poles = poles[np.abs(poles) > 1e-7 * np.abs(poles).max()]
    lowest, highest = 1e-2 * np.abs(poles).min(), 1e1 * np.abs(poles).max()
    spread = np.sinh(np.linspace(-6.0, 6.0, 121))
    resonances = [pole.imag + abs(pole.real) * spread for pole in poles if pole.imag > 0]
    frequency = np.unique(np.concatenate([np.geomspace(lowest, highest, points), *resonances]))
    if discrete:
        highest = min(highest, (1 - 1e-9) * math.pi / loop.dt)
    return np.asarray(frequency[(frequency >= lowest) & (frequency <= highest)])
