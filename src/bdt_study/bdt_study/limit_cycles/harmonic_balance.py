"""Limit cycle of the linear controller with backlash, predicted.

The loop of figure 3 at a constant gap is linear but for the play operator of eq. 6, and both are
homogeneous: the gap times two gives the same motion times two, at the same frequency. So at every
gap above zero there is the same limit cycle in units of the gap. "Converges when the gap is small"
(figure 3) is a matter of size beside the step of the reference, not of stability.

Two predictions; :mod:`bdt_study.limit_cycles.comparison` sets them beside the simulation:

- *Describing function* (python-control): L(j omega) N(A) = -1, as if only the fundamental passed
  the backlash. It holds where the loop suppresses the third harmonic of theta_d: for a structure
  ten times as stiff as table 1 or stiffer the frequency is right within 1 % and the fundamental
  within 3 % (not the peak to peak, which the harmonics flatten: 17 % high). It does *not* hold
  for table 1. There the limit cycle has 9.0 rad/s, three times that is the first mode
  (27.07 rad/s), and the third harmonic of q3 is 0.45 of the fundamental: the predicted frequency
  is 6 % low, the fundamental 18 % and the peak to peak 40 %.
- *Harmonic balance*: the same for all odd harmonics up to a highest one. Within 0.2 % of the
  simulation in frequency and peak to peak for table 1; what is left is the controller's sampling,
  which the prediction leaves out (0.02 % when the controller runs at 5000 Hz).

Neither covers a growing gap (slow beside a period of 0.7 s, so nearly constant), the dead zone, or
which steps lead into the limit cycle. When the first mode lies a little above three times the
frequency (stiffness between 1.2 and 1.3 times that of table 1) the limit cycle jumps from one
shape to another; the describing function shows nothing of it.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from control import StateSpace, describing_function_response, friction_backlash_nonlinearity
from numpy.typing import NDArray
from scipy.optimize import root

from bdt_controller.pid import PidGains
from bdt_plant.lead_screw import play
from bdt_plant.plant import PlantModel
from bdt_study.design.linear_model import (
    frequency_response,
    is_stable,
    loop_transfer,
    structure_model,
)

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

HIGHEST_HARMONIC = 15
"""Highest (odd) harmonic of the harmonic balance."""

POINTS = 512
"""Instants in a period at which harmonic balance evaluates the backlash."""


@dataclass(frozen=True)
class LimitCycle:
    """A symmetric oscillation of q3 at a constant gap.

    Attributes
    ----------
    gap : float
        Backlash gap theta_b [rad].
    frequency : float
        Angular frequency [rad/s].
    fundamental : float
        Amplitude of the fundamental of q3 [m].
    peak_to_peak : float
        Peak to peak of q3 [m].
    third_harmonic : float
        Amplitude of the third harmonic of q3 over that of the fundamental.
    """

    gap: float
    frequency: float
    fundamental: float
    peak_to_peak: float
    third_harmonic: float


@lru_cache(maxsize=64)  # where harmonic balance begins, too
def describing_function_cycle(model: PlantModel, gains: PidGains, gap: float) -> LimitCycle | None:
    """Return the limit cycle that the describing function of the backlash predicts.

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism.
    gains : PidGains
        Gains of the linear controller (eq. 5).
    gap : float
        Constant gap theta_b [rad], positive.

    Returns
    -------
    LimitCycle or None
        Of several solutions of L(j omega) N(A) = -1 the one with the largest amplitude, which is
        the stable one: at larger amplitudes still, N comes ever closer to the loop without
        backlash, in which motions decay. None without a solution, and for a loop that is not even
        stable without backlash.
    """
    loop = loop_transfer(model, gains)
    if not is_stable(loop):
        return None
    backlash = friction_backlash_nonlinearity(gap)
    amplitudes = 0.5 * gap * (1.0 + np.geomspace(1e-2, 1e2, 80))
    response = describing_function_response(
        loop,
        backlash,
        amplitudes,
        np.geomspace(0.1, 300.0, 1200),
        warn_nyquist=False,
    )
    if not response.intersections:
        return None
    amplitude, frequency = max((float(a), float(w)) for a, w in response.intersections)
    transfer = frequency_response(structure_model(model.structure), np.array([frequency]))[0]
    screw = model.lead_screw.pitch * abs(backlash.describing_function(amplitude)) * amplitude
    size = float(abs(transfer) * screw)
    return LimitCycle(gap, frequency, size, 2 * size, 0.0)


def harmonic_balance_cycle(
    model: PlantModel,
    gains: PidGains,
    gap: float,
    highest_harmonic: int = HIGHEST_HARMONIC,
) -> LimitCycle | None:
    """Return the limit cycle for which all odd harmonics up to a highest one balance.

    For each harmonic h of the motor's angle, Theta_m(h) = -L(j h omega) Theta_d(h), where theta_d
    is the play of theta_m over a period. With the first harmonic alone this is the describing
    function.

    Parameters
    ----------
    model, gains, gap
        See :func:`describing_function_cycle`.
    highest_harmonic : int
        Odd.

    Returns
    -------
    LimitCycle or None
        None if the describing function, from which the iteration starts, finds none, or if the
        iteration does not converge.
    """
    # Homogeneous: solve at a gap of 1 rad and scale.
    start = describing_function_cycle(model, gains, 1.0)
    if start is None:
        return None
    loop, structure = loop_transfer(model, gains), structure_model(model.structure)
    transfer = frequency_response(structure, np.array([start.frequency]))[0]
    # The amplitude of theta_m behind the predicted q3, with the losses of the backlash put back.
    first = start.fundamental / (abs(transfer) * model.lead_screw.pitch) + 0.5
    frequency, angles = start.frequency, np.array([first], dtype=np.complex128)
    # One harmonic more at a time: from the fundamental alone the iteration loses its way.
    for highest in range(1, highest_harmonic + 1, 2):
        orders = np.arange(1, highest + 1, 2)
        angles = np.append(angles, np.zeros(orders.size - angles.size))
        solution = _balance(loop, orders, frequency, angles)
        if solution is None:
            return None
        frequency, angles = solution
    transfers = frequency_response(structure, frequency * orders.astype(np.float64))
    position = transfers * _screw(orders, angles)
    position = gap * model.lead_screw.pitch * position
    return LimitCycle(
        gap,
        frequency,
        float(abs(position[0])),
        float(np.ptp(_waveform(orders, position))),
        float(abs(position[1] / position[0])) if orders.size > 1 else 0.0,
    )


def _balance(
    loop: StateSpace, orders: NDArray[np.int64], frequency: float, angles: ComplexArray
) -> tuple[float, ComplexArray] | None:
    """Return frequency and harmonics of theta_m that balance at a gap of 1 rad."""

    def unbalance(unknown: FloatArray) -> FloatArray:
        response = frequency_response(loop, unknown[0] * orders.astype(np.float64))
        rest = _angles(unknown) + response * _screw(orders, _angles(unknown))
        return np.concatenate([rest.real, rest.imag])

    guess = np.concatenate([[frequency], angles.real, angles.imag[1:]])
    found = root(unbalance, guess, method="hybr", options={"xtol": 1e-9})
    # The play is evaluated at instants: the balance has steps of about this size.
    if np.abs(unbalance(found.x)).max() > 1e-4 * abs(found.x[1]) or found.x[0] <= 0:
        return None
    return float(found.x[0]), _angles(found.x)


def _screw(orders: NDArray[np.int64], angles: ComplexArray) -> ComplexArray:
    """Return the harmonics of theta_d for those of theta_m, at a gap of 1 rad."""
    return _coefficients(orders, _periodic_play(_waveform(orders, angles), 1.0))


def _angles(unknown: FloatArray) -> ComplexArray:
    """Return the harmonics of theta_m; the phase of the first is zero, its place is omega's."""
    count = unknown.size // 2
    imaginary = np.concatenate([[0.0], unknown[1 + count :]])
    return np.asarray(unknown[1 : 1 + count] + 1j * imaginary, dtype=np.complex128)


def _waveform(orders: NDArray[np.int64], coefficients: ComplexArray) -> FloatArray:
    """Return Re sum_h c_h exp(j h x) over a period, shape (POINTS,)."""
    phase = 2 * math.pi * np.arange(POINTS) / POINTS
    return np.asarray((np.exp(1j * np.outer(phase, orders)) @ coefficients).real)


def _coefficients(orders: NDArray[np.int64], waveform: FloatArray) -> ComplexArray:
    """Return the inverse of :func:`_waveform` for the harmonics `orders`."""
    return np.asarray(np.fft.fft(waveform)[orders] * (2 / POINTS), dtype=np.complex128)


def _periodic_play(motor: FloatArray, gap: float) -> FloatArray:
    """Return theta_d over a period of theta_m; the first of two periods forgets the beginning."""
    angles, screw = motor.tolist(), float(motor[0])
    for angle in angles:
        screw = play(screw, angle, gap)
    return np.array([screw := play(screw, angle, gap) for angle in angles])
