"""Both filters of the angle observer as one compiled recursion.

A recursion waits for its own last result most of the time. Side by side the two take less than
half the time of two passes of scipy's ``lfilter``, whose floats these are, bit for bit; and numba
with its cache warm starts sooner than ``scipy.signal``.
"""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_plant.compilation import GIVEN, WRITTEN, compile_loop

FloatArray = NDArray[np.float64]
Coefficients = tuple[tuple[float, ...], tuple[float, ...]]
FilterState = tuple[float, float, float, float, float, float, float]

AT_REST: FilterState = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""What the recursion remembers before the first sample of a mechanism at rest."""


def coefficients(numerator: FloatArray, denominator: FloatArray) -> Coefficients:
    """Return the coefficients of a recursion whose newest output has the factor one."""
    first = denominator[0]
    return tuple((numerator / first).tolist()), tuple((denominator / first).tolist())


def filter_motor_and_screw(
    voltage: FloatArray,
    position: FloatArray,
    rest: float,
    pitch: float,
    motor: Coefficients,
    inverse: Coefficients,
    memory: FilterState,
    theta_m: FloatArray,
    theta_d: FloatArray,
) -> FilterState:
    """Run eqs 10 and 11 as recursions in transposed direct form II.

    Parameters
    ----------
    voltage, position : ndarray, shape (n,)
        Inputs: motor voltage [V] and position of platform 3 [m].
    rest : float
        Position before the first sample [m], from which the inverse sees the rest: without this
        it would take a platform that rests elsewhere for one that jumped.
    pitch : float
        Pitch p of the lead screw [m/rad] (eq. 1).
    motor : Coefficients
        G1(z): four coefficients above, four below.
    inverse : Coefficients
        Inverse of G2(z): five coefficients above, three below.
    memory : FilterState
        From the previous samples: three numbers of the motor, four of the inverse.
    theta_m, theta_d : ndarray, shape (n,)
        Written: angles of the motor and of the lead screw [rad].

    Returns
    -------
    FilterState
        For the next samples.
    """
    (b0, b1, b2, b3), (_, a1, a2, a3) = motor
    (c0, c1, c2, c3, c4), (_, e1, e2) = inverse
    m1, m2, m3, s1, s2, s3, s4 = memory
    for n in range(voltage.size):
        u, moved = voltage[n], position[n] - rest
        angle = m1 + b0 * u
        m1 = m2 + b1 * u - a1 * angle
        m2 = m3 + b2 * u - a2 * angle
        m3 = b3 * u - a3 * angle
        d = s1 + c0 * moved
        s1 = s2 + c1 * moved - e1 * d
        s2 = s3 + c2 * moved - e2 * d
        s3 = s4 + c3 * moved
        s4 = c4 * moved
        theta_m[n] = angle
        theta_d[n] = (d + rest) / pitch
    return m1, m2, m3, s1, s2, s3, s4


@cache
def compiled_filters() -> Any:
    """Return :func:`filter_motor_and_screw` compiled."""
    filters = (
        "Tuple((UniTuple(float64, 4), UniTuple(float64, 4))), "
        "Tuple((UniTuple(float64, 5), UniTuple(float64, 3)))"
    )
    memory = f"UniTuple(float64, {len(AT_REST)})"
    arguments = f"{GIVEN}, {GIVEN}, float64, float64, {filters}, {memory}, {WRITTEN}, {WRITTEN}"
    return compile_loop(filter_motor_and_screw, f"{memory}({arguments})")
