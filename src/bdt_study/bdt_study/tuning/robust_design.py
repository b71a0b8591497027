"""Gains for the worst of many mechanisms: the smallest largest sensitivity over all of them.

The search sees the loop as it runs, sampled, on a grid of frequencies; python-control judges what
comes out (:mod:`bdt_study.tuning.linear_judgment`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from bdt_controller.notch import NO_NOTCH, NotchFilter
from bdt_controller.pid import PidGains
from bdt_plant.plant import PlantModel
from bdt_study.design.linear_model import frequency_response, plant_model

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

PID_STARTS = ((-0.3, 0.75), (0.5, 2.0), (-0.2, 0.3), (0.9, 1.0))
"""Where searches of a PID begin: gain far above the crossover, T_f times the bandwidth."""
NOTCH_STARTS = ((0.9, 1.0, 0.1, 0.6), (2.0, 0.5, 0.1, 0.8))
"""The same with a filter, and the dampings of its zeros and poles."""
UNSTABLE = 100.0
"""Added to the sensitivity for each mechanism that is not stable."""
FASTEST_FILTER = 0.05
"""Smallest T_f times the bandwidth: a faster filter makes voltage of noise."""
LARGEST_LEAD = 5.0
"""Largest gain of the PID far above the crossover, over K_p: a larger one amplifies noise."""
ZERO_DAMPINGS, POLE_DAMPINGS = (0.0, 1.0), (0.2, 1.5)
"""Dampings of a filter that are searched."""


@dataclass(frozen=True)
class ControllerDesign:
    """A controller to be tried.

    Attributes
    ----------
    name : str
        What it is called in tables.
    gains : PidGains
        Gains of eq. 4.
    notch : NotchFilter
        Filter in series.
    """

    name: str
    gains: PidGains
    notch: NotchFilter = NO_NOTCH


class RobustSearch:
    """Looks for the controller with the smallest worst sensitivity over some mechanisms.

    Parameters
    ----------
    models : sequence of PlantModel
        The mechanisms; the first is the one that the bandwidth is set for.
    bandwidth : float
        First gain crossover of the first mechanism [rad/s].
    control_rate : float
        Rate of measurements [Hz].
    """

    def __init__(self, models: Sequence[PlantModel], bandwidth: float, control_rate: float) -> None:
        self._bandwidth, self._period = bandwidth, 1.0 / control_rate
        plants = [plant_model(model) for model in models]
        modes = [pole.imag for pole in plants[0].poles() if pole.imag > 0.0]
        self._mode = float(min(modes))
        highest = min(100.0 * bandwidth, 0.9 * math.pi * control_rate)
        grid = [np.geomspace(0.03 * bandwidth, highest, 500)]
        grid += [mode * np.linspace(0.85, 1.15, 151) for mode in modes]
        self._frequency = np.unique(np.concatenate(grid))
        self._early = self._frequency < 0.999 * bandwidth
        # A voltage that is held is half a period late.
        late = np.exp(-0.5j * self._frequency * self._period)
        self._plants = np.array([frequency_response(one, self._frequency) for one in plants]) * late
        self._crossing = frequency_response(plants[0], np.array([bandwidth]))

    def design(self, name: str, integral_time: float, *, with_notch: bool) -> ControllerDesign:
        """Return the best controller for an integral time T_i = K_p / K_i [s].

        Parameters
        ----------
        name : str
            Its name.
        integral_time : float
            T_i [s].
        with_notch : bool
            Whether it has a filter at the first mode.
        """
        starts: list[tuple[float, ...]] = list(NOTCH_STARTS if with_notch else PID_STARTS)
        found = [
            minimize(
                self._objective,
                [start[0], math.log(start[1] / self._bandwidth), *start[2:]],
                args=(integral_time,),
                method="Nelder-Mead",
                options={"xatol": 1e-4, "fatol": 1e-4, "maxiter": 300 * len(start)},
            )
            for start in starts
        ]
        best = min(found, key=lambda one: float(one.fun)).x.tolist()
        return self._controller(name, best, integral_time)

    def sensitivities(self, design: ControllerDesign) -> FloatArray:
        """Return the largest sensitivity of each mechanism as the search sees it, shape (m,)."""
        return np.asarray(1.0 / np.abs(1.0 + self._response(design)).min(axis=1))

    def _controller(
        self, name: str, point: Sequence[float], integral_time: float
    ) -> ControllerDesign:
        filter_time = math.exp(point[1])
        notch = NO_NOTCH
        if len(point) > 2:
            zeros, poles = np.clip(point[2], *ZERO_DAMPINGS), np.clip(point[3], *POLE_DAMPINGS)
            notch = NotchFilter(_rounded(self._mode), _rounded(zeros), _rounded(poles))
        unit = PidGains(1.0, 1.0 / integral_time, (point[0] - 1.0) * filter_time, filter_time)
        at_bandwidth = np.array([self._bandwidth])
        shape = _answer(unit, notch, at_bandwidth, self._period) * self._crossing
        proportional = 1.0 / float(np.abs(shape)[0])
        gains = PidGains(
            _rounded(proportional),
            _rounded(proportional * unit.integral),
            _rounded(proportional * unit.derivative),
            _rounded(filter_time),
        )
        return ControllerDesign(name, gains, notch)

    def _response(self, design: ControllerDesign) -> ComplexArray:
        answer = _answer(design.gains, design.notch, self._frequency, self._period)
        return np.asarray(answer * self._plants)

    def _objective(self, point: FloatArray, integral_time: float) -> float:
        """Return the worst sensitivity, and more for what is not allowed."""
        beyond = max(math.log(FASTEST_FILTER / self._bandwidth) - float(point[1]), 0.0)
        beyond += max(float(point[0]) - LARGEST_LEAD, 0.0) + max(float(point[1]) - 4.0, 0.0)
        if beyond > 0.0:
            return 1e4 * (1.0 + beyond)
        loop = self._response(self._controller("", point.tolist(), integral_time))
        distance = 1.0 + loop
        # Two integrators: 1 + L comes from -180 degrees, and of a stable loop turns to 0.
        turn = np.unwrap(np.angle(distance), axis=1)
        unstable = int(np.sum(np.abs(turn[:, -1] - turn[:, 0] - math.pi) > 1.0))
        crossed = bool((np.abs(loop[0][self._early]) <= 1.0).any())
        worst = float(1.0 / np.abs(distance).min())
        return worst + UNSTABLE * (unstable + crossed)


def _answer(
    gains: PidGains, notch: NotchFilter, frequency: FloatArray, period: float
) -> ComplexArray:
    """Return the response of PID and filter, each error standing for the period that ends with it.

    These are the z-transforms of :func:`bdt_controller.pid.pid_step` and
    :func:`bdt_controller.notch.notch_step`.
    """
    s = 1j * frequency
    z = np.exp(s * period)
    decay = math.exp(-period / gains.filter_time)
    passed = 1.0 - (1.0 - decay) * z / (z - decay)
    answer = (
        gains.proportional
        + gains.integral * period * z / (z - 1.0)
        + gains.derivative / gains.filter_time * passed
    )
    if notch.frequency:
        w = notch.frequency
        trapezoid = 2.0 / period * (z - 1.0) / (z + 1.0)
        rate = trapezoid * w * w * 2.0 * z / (z + 1.0)
        rate /= trapezoid * trapezoid + 2.0 * notch.pole_damping * w * trapezoid + w * w
        answer = answer * (1.0 - 2.0 * (notch.pole_damping - notch.zero_damping) / w * rate)
    return np.asarray(answer)


def _rounded(value: float) -> float:
    return float(f"{value:.5g}")
