"""Friction that yields before it slides (presliding).

Surfaces touch at asperities, which bend like springs before they slip. Springs of several yield
angles a_i, each with a share s_i of the friction, make up the curves by which friction builds up
after a reversal (Iwan, 1966; also known as Maxwell slip), be they Dahl's, LuGre's or others:

    friction = F (s_0 sgn(omega_m) + sum_i s_i z_i / a_i),

where the bend z_i of a spring follows the motor's angle within a_i to either side, and s_0 is what
is left for friction that does not yield. The sizes F and s_0 F are those of a motor that slides.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.motor import MotorState
from bdt_plant.resisted_motor import ResistedMotor, resisted_motor_step

FloatArray = NDArray[np.float64]

YIELD_ANGLES = (2.5e-3, 1e-2, 4e-2)
"""Angles of the motor up to which the springs bend before they slip [rad]."""
SPRINGS = len(YIELD_ANGLES)
"""Number of springs."""


class YieldingFriction(NamedTuple):
    """How much of the friction yields.

    Attributes
    ----------
    shares : tuple of float
        Share of the friction of each spring.
    rigid : float
        Share that does not yield.
    """

    shares: tuple[float, float, float]
    rigid: float


RIGID = YieldingFriction((0.0, 0.0, 0.0), 1.0)
"""Coulomb friction: nothing yields."""


def bend_springs(bends: FloatArray, turned: float) -> None:
    """Bend the springs as a motor does that turns.

    Parameters
    ----------
    bends : ndarray, shape (springs,)
        Bends of the springs [rad]; changed.
    turned : float
        Angle by which the motor has turned [rad].
    """
    for spring in range(SPRINGS):
        most = YIELD_ANGLES[spring]
        bends[spring] = min(max(bends[spring] + turned, -most), most)


def elastic_share(bends: FloatArray, turned: float, friction: YieldingFriction) -> float:
    """Return the torque of the springs after a turn of the motor, over the whole friction.

    Parameters
    ----------
    bends : ndarray, shape (springs,)
        Bends of the springs before [rad].
    turned : float
        Angle by which the motor turns [rad].
    friction : YieldingFriction
        How much of the friction yields.
    """
    torque = 0.0
    for spring in range(SPRINGS):
        bent = (bends[spring] + turned) / YIELD_ANGLES[spring]
        torque += friction.shares[spring] * min(max(bent, -1.0), 1.0)
    return torque


def elastic_stiffness(bends: FloatArray, turned: float, friction: YieldingFriction) -> float:
    """Return the stiffness of the springs that do not slip in a turn, over the friction [1/rad].

    Parameters are those of :func:`elastic_share`.
    """
    stiffness = 0.0
    for spring in range(SPRINGS):
        if abs(bends[spring] + turned) < YIELD_ANGLES[spring]:
            stiffness += friction.shares[spring] / YIELD_ANGLES[spring]
    return stiffness


def sliding_direction(bends: FloatArray) -> float:
    """Return 1 or -1 where all springs slip forward or backward, else 0."""
    direction = 1.0 if bends[0] > 0.0 else -1.0
    for spring in range(SPRINGS):
        if direction * bends[spring] < YIELD_ANGLES[spring]:
            return 0.0
    return direction


def yielding_motor_step(
    motor: MotorState,
    voltage: float,
    loads: tuple[float, float, float],
    size: float,
    bends: FloatArray,
    friction: YieldingFriction,
    step: ResistedMotor,
) -> MotorState:
    """Advance a motor with yielding friction by one step with `voltage` [V] held.

    The springs pull over the step as they do in its end, which is stable however stiff they are;
    the error is of first order in the step.

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
        Bends of the springs at the beginning [rad].
    friction : YieldingFriction
        How much of the friction yields.
    step : ResistedMotor
        From :func:`bdt_plant.resisted_motor.discretize_resisted_motor`.
    """
    load, backward, forward = loads
    backward, forward = backward + size * friction.rigid, forward + size * friction.rigid
    turned = 0.0
    if motor.speed * sliding_direction(bends) <= 0.0:
        held = size * elastic_share(bends, 0.0, friction)
        first = resisted_motor_step(motor, voltage, load + held, backward, forward, step)
        turned = first.angle - motor.angle
        # Each ampere that is held turns the motor less.
        per_current = step.motor.angle[0] + step.resistance * step.motor.angle[2]
        turned /= 1.0 + size * per_current * elastic_stiffness(bends, turned, friction)
    held = size * elastic_share(bends, turned, friction)
    return resisted_motor_step(motor, voltage, load + held, backward, forward, step)
