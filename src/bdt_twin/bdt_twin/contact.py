"""Backlash gap from the angles of samples in contact (eqs 13 and 14)."""

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.compilation import GIVEN, compile_loop

FloatArray = NDArray[np.float64]


class ContactSums(NamedTuple):
    """Sums over samples in contact, in multiples of l/2: integers, so no order rounds differently.

    Attributes
    ----------
    forward, backward : int
        Numbers of samples with the screw moving forward (``t_+``) and backward (``t_-``).
    ceiled, floored : int
        Sums of the rounded angle differences over ``t_+`` and ``t_-``.
    """

    forward: int
    backward: int
    ceiled: int
    floored: int


NO_CONTACT = ContactSums(0, 0, 0, 0)


def contact_sums(
    theta_m: FloatArray,
    theta_d: FloatArray,
    sample_time: float,
    velocity_threshold: float,
    rounding: float,
    block: int,
) -> list[ContactSums]:
    """Return the sums of eq. 13, one for each `block` of samples.

    Parameters
    ----------
    theta_m, theta_d : ndarray, shape (1 + n * block,)
        Aligned angles [rad]; the first sample only serves the first difference.
    sample_time : float
        Sample time [s].
    velocity_threshold : float
        Speed of the lead screw above which it counts as moving [rad/s].
    rounding : float
        Scale l [deg]; angles are rounded to multiples of l/2 (eq. 14).
    block : int
        Number of samples in a block.
    """
    sums = np.zeros((len(ContactSums._fields), (theta_m.size - 1) // block), dtype=np.int64)
    compiled_sums()(theta_m, theta_d, velocity_threshold * sample_time, 0.5 * rounding, block, sums)
    return list(map(ContactSums, *sums.tolist()))


def add_contacts(
    theta_m: FloatArray,
    theta_d: FloatArray,
    threshold: float,
    half_scale: float,
    block: int,
    sums: NDArray[np.int64],
) -> None:
    """Add each sample in contact to the sums of its block (eqs 13 and 14).

    Parameters
    ----------
    theta_m, theta_d : ndarray, shape (1 + n * block,)
        Aligned angles [rad].
    threshold : float
        Angle by which a moving screw turns in a sample [rad].
    half_scale : float
        l/2 [deg].
    block : int
        Number of samples in a block.
    sums : ndarray, shape (4, n)
        Written: rows as in :class:`ContactSums`.
    """
    degrees = 180.0 / math.pi
    for number in range(sums.shape[1]):
        # Indices that begin at zero in each block let the compiler work on samples side by side.
        motor = theta_m[number * block : (number + 1) * block + 1]
        screw = theta_d[number * block : (number + 1) * block + 1]
        forward = backward = ceiled = floored = 0
        for before in range(block):
            motor_turn = motor[before + 1] - motor[before]
            screw_turn = screw[before + 1] - screw[before]
            difference = (motor[before + 1] - screw[before + 1]) * degrees / half_scale
            # By eq. 6 a screw that moves turns with the motor. Around a reversal the inverse
            # filter leaves a few samples with opposite signs; one of them alone in a window would
            # make the gap zero.
            if screw_turn > threshold and motor_turn > 0.0:
                forward += 1
                ceiled += math.ceil(difference)
            elif screw_turn < -threshold and motor_turn < 0.0:
                backward += 1
                floored += math.floor(difference)
        sums[0, number] = forward
        sums[1, number] = backward
        sums[2, number] = ceiled
        sums[3, number] = floored


def gap_from_sums(sums: ContactSums, rounding: float) -> float | None:
    """Return the gap theta_b [rad] of eq. 13, or None unless both directions occur.

    Parameters
    ----------
    sums : ContactSums
        Sums over the window.
    rounding : float
        Scale l [deg] with which the sums were made.
    """
    if not sums.forward or not sums.backward:
        return None
    means = sums.ceiled / sums.forward - sums.floored / sums.backward
    return math.radians(0.5 * rounding * means)


@cache
def compiled_sums() -> Any:
    """Return :func:`add_contacts` compiled."""
    numbers = "float64, float64, int64, Array(int64, 2, 'C')"
    return compile_loop(add_contacts, f"void({GIVEN}, {GIVEN}, {numbers})")
