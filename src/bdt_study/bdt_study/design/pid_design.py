"""Design of the PID (eq. 4) for what the paper asks of it, as robust as that allows.

The paper: "zero steady-state error, a bandwidth frequency of 10 rad/s, and a minimum phase margin
of 10 deg". It leaves open which bandwidth is meant. Here it is the *first gain crossover* of L; the
-3 dB frequency of T is reported beside it. For the mechanism of table 1 the two differ by a factor
of 2.8, because the first mode (27 rad/s, damping 5 %) lifts ``|T|`` over -3 dB up to its resonance.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from bdt_controller.pid import PidGains
from bdt_plant.plant import PlantModel
from bdt_study.design.linear_model import (
    frequency_response,
    is_stable,
    loop_transfer,
    pid_model,
    plant_model,
    sampled_loop_transfer,
)
from bdt_study.design.loop_margins import LoopMargins, loop_margins

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

HIGH_FREQUENCY_GAINS = np.linspace(-3.0, 10.0, 66)
"""Searched gains of the PID far above the crossover, 1 + K_d / (T_f K_p); below 1 it is a lag."""

FILTER_TIMES = np.geomspace(0.03, 30.0, 46)
"""Searched time constants T_f times the bandwidth frequency."""

INTERPOLATION = 1e-3
"""Room [rad] that the search leaves for reading phase margins between two frequencies."""

UNMET = 1e6
"""Larger than any maximum sensitivity that is of use."""

STARTS = 3
"""Best points of the coarse search from which the fine search starts."""


@dataclass(frozen=True)
class PidDesign:
    """What :func:`design_pid` found.

    Attributes
    ----------
    gains : PidGains
        Gains of eq. 4.
    margins : LoopMargins
        Of the loop of eqs 2 to 5 in continuous time.
    sampled : LoopMargins
        Of the same loop as it runs: PID of the core at the control rate, voltage held.
    control_rate : float
        That rate [Hz].
    """

    gains: PidGains
    margins: LoopMargins
    sampled: LoopMargins
    control_rate: float


def design_pid(
    model: PlantModel,
    *,
    bandwidth: float = 10.0,
    phase_margin: float = math.radians(10.0),
    integral_time: float | None = None,
    control_rate: float = 500.0,
) -> PidDesign:
    """Return the PID with the smallest maximum sensitivity M_s that meets the paper's demands.

    The demands: integral action (zero steady-state error), first gain crossover at `bandwidth`,
    every phase margin at least `phase_margin`, closed loop stable in continuous time and sampled.

    M_s alone would switch the integral action off: the motor integrates already, and M_s falls
    from 3.66 to 2.86 as K_i goes to zero. So the integral time T_i = K_p / K_i is part of the
    demand. By default it is 1 / `bandwidth`: the integral action is as fast as the loop. What is
    left, K_d and T_f, is searched on a coarse grid and then by Nelder and Mead's method from its
    best points. The result is the same on every call.

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism.
    bandwidth : float
        First gain crossover [rad/s].
    phase_margin : float
        Smallest magnitude of the phase margin allowed at any crossover [rad].
    integral_time : float, optional
        T_i = K_p / K_i [s].
    control_rate : float
        Rate of measurements of the sampled loop [Hz].

    Raises
    ------
    ValueError
        If a demand is not a positive number, or if the search finds nothing that meets them all.
    """
    demands = {
        "bandwidth": bandwidth,
        "phase_margin": phase_margin,
        "integral_time": 1.0 if integral_time is None else integral_time,
        "control_rate": control_rate,
    }
    for name, value in demands.items():
        if not (math.isfinite(value) and value > 0):
            raise ValueError(f"design_pid: {name} = {value!r}: must be a positive number")
    if integral_time is None:
        integral_time = 1.0 / bandwidth
    search = _Search(model, bandwidth, phase_margin, integral_time)
    fine = [_refine(search.objective, start) for start in search.starts()]
    for _, point in sorted(fine, key=lambda found: found[0]):
        gains = search.gains(point)
        margins = loop_margins(loop_transfer(model, gains))
        sampled = loop_margins(sampled_loop_transfer(model, gains, control_rate))
        # The search sees a grid of frequencies and no sampling; these see everything.
        if margins.stable and sampled.stable and margins.smallest_phase_margin >= phase_margin:
            return PidDesign(gains, margins, sampled, control_rate)
    raise ValueError(
        f"design_pid: no PID found with a crossover at {bandwidth:g} rad/s, phase margins of at "
        f"least {math.degrees(phase_margin):g} degrees and T_i = {integral_time:g} s"
    )


class _Search:
    """What is searched: points (high-frequency gain, log T_f), each of which is a PID."""

    def __init__(
        self, model: PlantModel, bandwidth: float, phase_margin: float, integral_time: float
    ) -> None:
        self._plant = plant_model(model)
        self._bandwidth = bandwidth
        self._phase_margin = phase_margin + INTERPOLATION
        self._integral_time = integral_time
        poles = self._plant.poles()
        spread = np.sinh(np.linspace(-5.0, 5.0, 61))
        self._frequency = np.unique(
            np.concatenate(
                [
                    bandwidth * np.geomspace(1 / 30, 30, 1801),
                    bandwidth * np.geomspace(30, 1000, 100),
                    *(pole.imag + abs(pole.real) * spread for pole in poles if pole.imag > 0),
                ]
            )
        )
        self._frequency = self._frequency[self._frequency >= bandwidth / 30]
        self._response = frequency_response(self._plant, self._frequency)
        self._at_bandwidth = frequency_response(self._plant, np.array([bandwidth]))
        self._early = self._frequency < bandwidth * (1 - 1e-6)

    def gains(self, point: FloatArray) -> PidGains:
        """Return the PID of a point: K_p is such that |L| = 1 at the bandwidth."""
        filter_time = math.exp(point[1])
        shape = self._shape(point, np.array([self._bandwidth]))
        proportional = 1.0 / float(np.abs(shape * self._at_bandwidth)[0])
        return PidGains(
            proportional,
            proportional / self._integral_time,
            proportional * (float(point[0]) - 1.0) * filter_time,
            filter_time,
        )

    def starts(self) -> list[FloatArray]:
        """Return the best points of the coarse grid."""
        times = np.log(FILTER_TIMES / self._bandwidth).tolist()
        grid = [np.array([gain, time]) for gain in HIGH_FREQUENCY_GAINS for time in times]
        values = np.array([self._sensitivity(point) for point in grid])
        best = (grid[k] for k in np.argsort(values, kind="stable") if math.isfinite(values[k]))
        return list(islice((point for point in best if self._stable(point)), STARTS))

    def objective(self, point: FloatArray) -> float:
        """Return M_s; more than `UNMET` if a demand is not met."""
        value = self._sensitivity(point)
        return value if math.isfinite(value) and self._stable(point) else math.inf

    def _shape(self, point: FloatArray, frequency: FloatArray) -> ComplexArray:
        s = 1j * frequency
        filtered = 1 / (math.exp(point[1]) * s + 1)
        return np.asarray(1 + 1 / (self._integral_time * s) + (point[0] - 1) * (1 - filtered))

    def _stable(self, point: FloatArray) -> bool:
        return is_stable(self._plant * pid_model(self.gains(point)))

    def _sensitivity(self, point: FloatArray) -> float:
        """Return M_s, as if the loop were stable; more than `UNMET` if a demand is not met."""
        loop = self._shape(point, self._frequency) * self._response
        loop /= np.abs(self._shape(point, np.array([self._bandwidth])) * self._at_bandwidth)
        size = np.abs(loop)
        if (size[self._early] <= 1).any():
            return math.inf
        crossing = np.flatnonzero((size[1:] > 1) != (size[:-1] > 1))
        share = (1 - size[crossing]) / (size[crossing + 1] - size[crossing])
        crossed = loop[crossing] + share * (loop[crossing + 1] - loop[crossing])
        lack = self._phase_margin - np.min(np.abs(np.angle(-crossed)), initial=math.inf)
        if lack > 0:
            # Finite, so that the fine search finds its way from a point that just fails.
            return UNMET * (1.0 + float(lack))
        return 1 / math.sqrt(_smooth_minimum(np.log(self._frequency), np.abs(1 + loop) ** 2))


def _smooth_minimum(places: FloatArray, values: FloatArray) -> float:
    """Return the lowest vertex of the parabolas through each local minimum and its neighbors.

    At the optimum two peaks of |S| are equally high, and the best gains depend on their heights
    to a part in 10^5: the grid of frequencies must not show.
    """
    middle = np.flatnonzero((values[1:-1] <= values[:-2]) & (values[1:-1] < values[2:])) + 1
    before, after = np.diff(places)[middle - 1], np.diff(places)[middle]
    falling = (values[middle] - values[middle - 1]) / before
    rising = (values[middle + 1] - values[middle]) / after
    slope = (falling * after + rising * before) / (before + after)
    curvature = (rising - falling) / (before + after)
    # Where the curve rushes past -1 between two frequencies a parabola knows nothing.
    vertices = np.maximum(values[middle] - slope**2 / (4 * curvature), 0.5 * values[middle])
    return float(np.min(vertices, initial=values.min()))


def _refine(
    objective: Callable[[FloatArray], float], start: FloatArray
) -> tuple[float, FloatArray]:
    """Return value and place of the minimum near a point of the coarse grid."""
    # The maximum of several peaks has edges, on which a simplex may collapse: begin anew there.
    for size in (0.1, 0.02, 0.004):
        simplex = start + size * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
        options = {"initial_simplex": simplex, "xatol": 1e-7, "fatol": 1e-9, "maxiter": 300}
        start = minimize(objective, start, method="Nelder-Mead", options=options).x
    return objective(start), start
