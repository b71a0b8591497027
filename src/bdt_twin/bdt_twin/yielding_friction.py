"""Friction that yields before it slides (presliding).

Surfaces touch at asperities, which bend like springs before they slip. From a reversal on friction
builds up with the motor's angle x as in the models of Dahl and LuGre,

    friction = F (1 - 2 exp(-x / theta_y)),

with the yield angle theta_y, and from a rest within this curve on curves of half its size. Springs
that slip at different angles make up just that (Iwan, 1966; also known as Maxwell slip):

    friction = F mean(z_i),    z_i in [-1, 1] follows x / (a_i theta_y).

Their angles are distributed by a gamma distribution of shape 2 and mean 1, of which three springs
with a third of the friction each stand for a third each; the curve is off by 0.063 F at most. F
is the friction of a motor that slides.
"""

import numpy as np
from numpy.typing import NDArray

from bdt_plant.motor import MotorState
from bdt_plant.resisted_motor import ResistedMotor, resisted_motor_step

FloatArray = NDArray[np.float64]

SLIP_ANGLES = (0.3543, 0.8490, 1.7967)
"""Angles from rest at which the springs slip, over the yield angle: a_i."""
PER_SLIP_ANGLE = tuple(1.0 / angle for angle in SLIP_ANGLES)
"""Their inverse: multiplying is quicker than dividing."""
SPRINGS = len(SLIP_ANGLES)
"""Number of springs."""


def bend_springs(bends: FloatArray, turned: float, yield_angle: float) -> None:
    """Bend the springs as a motor does that turns.

    Parameters
    ----------
    bends : ndarray, shape (springs,)
        Bends z of the springs, -1 or 1 where they slip; changed.
    turned : float
        Angle by which the motor has turned [rad].
    yield_angle : float
        Yield angle theta_y [rad].
    """
    for spring in range(SPRINGS):
        bends[spring] = bend_after(bends, spring, turned, yield_angle)


def bend_after(bends: FloatArray, spring: int, turned: float, yield_angle: float) -> float:
    """Return the bend of one spring after a turn of the motor, -1 or 1 where it slips.

    Parameters
    ----------
    bends : ndarray, shape (springs,)
        Bends of the springs before.
    spring : int
        Which spring.
    turned : float
        Angle by which the motor turns [rad].
    yield_angle : float
        Yield angle theta_y [rad].
    """
    bent: float = bends[spring] + turned * (PER_SLIP_ANGLE[spring] / yield_angle)
    return min(max(bent, -1.0), 1.0)


def elastic_share(bends: FloatArray, turned: float, yield_angle: float) -> float:
    """Return the torque of the springs after a turn of the motor, over that of sliding friction.

    Parameters
    ----------
    bends : ndarray, shape (springs,)
        Bends of the springs before.
    turned : float
        Angle by which the motor turns [rad].
    yield_angle : float
        Yield angle theta_y [rad].
    """
    torque = 0.0
    for spring in range(SPRINGS):
        torque += bend_after(bends, spring, turned, yield_angle)
    return torque / SPRINGS


def held_share(bends: FloatArray, free: float, per_friction: float, yield_angle: float) -> float:
    """Return the mean torque of the springs over a step, over that of sliding friction.

    Parameters
    ----------
    bends : ndarray, shape (springs,)
        Bends of the springs before.
    free : float
        Angle by which the motor turns if the springs go on to pull as they do [rad].
    per_friction : float
        Angle by which the friction of a motor that slides turns it less in the step [rad].
    yield_angle : float
        Yield angle theta_y [rad].
    """
    direction = 1.0 if free > 0.0 else -1.0
    before = elastic_share(bends, 0.0, yield_angle)
    slope = elastic_slope(bends, 0.0, direction, yield_angle)
    stiffness = per_friction * slope
    # That of the end in the mean over the step, of a motor that settles evenly: 1/2 for soft
    # springs, 1 for those that hold it within a part of the step.
    weight = (6.0 + stiffness * (3.0 + stiffness)) / (12.0 + stiffness * (4.0 + stiffness))
    felt = weight * per_friction
    turned = free / (1.0 + felt * slope)
    # Newton's steps from rest never go too far, for springs only ever begin to slip on the way;
    # where none does, the last step was exact.
    for _ in range(SPRINGS):
        left = elastic_slope(bends, turned, direction, yield_angle)
        if left == slope:
            break
        slope, more = left, elastic_share(bends, turned, yield_angle) - before
        turned += (free - turned - felt * more) / (1.0 + felt * slope)
    return before + weight * (elastic_share(bends, turned, yield_angle) - before)


def elastic_slope(bends: FloatArray, turned: float, direction: float, yield_angle: float) -> float:
    """Return by how much the springs' torque grows as a motor goes on, over that of friction.

    Parameters
    ----------
    bends : ndarray, shape (springs,)
        Bends of the springs before.
    turned : float
        Angle by which the motor turns before it goes on [rad].
    direction : float
        Direction in which it goes on, 1 or -1.
    yield_angle : float
        Yield angle theta_y [rad].

    Returns
    -------
    float
        The slope [1/rad], of springs that do not slip.
    """
    slope = 0.0
    for spring in range(SPRINGS):
        if direction * bend_after(bends, spring, turned, yield_angle) < 1.0:
            slope += PER_SLIP_ANGLE[spring] / yield_angle
    return slope / SPRINGS


def sliding_direction(bends: FloatArray) -> float:
    """Return 1 or -1 where all springs slip forward or backward, else 0."""
    direction = 1.0 if bends[0] > 0.0 else -1.0
    for spring in range(SPRINGS):
        if direction * bends[spring] < 1.0:
            return 0.0
    return direction


def yielding_motor_step(
    motor: MotorState,
    voltage: float,
    loads: tuple[float, float, float],
    size: float,
    bends: FloatArray,
    yield_angle: float,
    step: ResistedMotor,
) -> MotorState:
    """Advance a motor with yielding friction by one step with `voltage` [V] held.

    It is stable however stiff the springs are; the error is of second order in the step while none
    begins to slip.

    Parameters
    ----------
    motor : MotorState
        Motor at the beginning of the step.
    voltage : float
        Motor voltage u [V].
    loads : tuple of float
        Torque against forward motion, and resistance to motion backward and forward, beside
        friction, as currents [A].
    size : float
        Friction of a motor that slides, as a current [A].
    bends : ndarray, shape (springs,)
        Bends of the springs at the beginning.
    yield_angle : float
        Yield angle theta_y [rad].
    step : ResistedMotor
        From :func:`bdt_plant.resisted_motor.discretize_resisted_motor`.
    """
    load, backward, forward = loads
    held = elastic_share(bends, 0.0, yield_angle)
    if motor.speed * sliding_direction(bends) <= 0.0:
        first = resisted_motor_step(motor, voltage, load + size * held, backward, forward, step)
        per_current = step.motor.angle[0] + step.resistance * step.motor.angle[2]
        free = first.angle - motor.angle
        held = held_share(bends, free, size * per_current, yield_angle)
    return resisted_motor_step(motor, voltage, load + size * held, backward, forward, step)
