"""Friction that yields before it slides (presliding), by Dahl's model.

Surfaces touch at asperities, which bend like springs before they slip. Their mean bend z, from -1
to 1, follows the motor's angle x (Dahl, 1968; LuGre's model is this with damping):

    friction = F z,    dz = (dx - z abs(dx)) / theta_y,

with the friction F of a motor that slides and the yield angle theta_y. From a reversal on friction
is F (1 - 2 exp(-x / theta_y)).
"""

from bdt_plant.elementary_functions import decaying_exponential
from bdt_plant.motor import MotorState
from bdt_plant.resisted_motor import ResistedMotor, resisted_motor_step

SLIDING = 0.9999
"""Bend from which on a motor slides, and the bend is 1."""
MOST_STEPS = 12
"""Largest number of Newton's steps; three or four are usual."""
STILL = 1e-6
"""Turn over the yield angle that a motor does not make: it waits for more torque."""
NEGLIGIBLE = 1e-5
"""Step over the yield angle that is the last one: what is left is its square."""


def way_left(turned: float, yield_angle: float) -> float:
    """Return which share of the way to where a motor slides is left after a turn.

    Parameters
    ----------
    turned : float
        Angle by which the motor turns [rad].
    yield_angle : float
        Yield angle theta_y [rad].
    """
    return decaying_exponential(-abs(turned) / yield_angle)


def bend_after(bend: float, turned: float, left: float) -> float:
    """Return the bend after a turn of the motor, 1 or -1 where it slides.

    Parameters
    ----------
    bend : float
        The bend before.
    turned : float
        Angle by which the motor turns [rad].
    left : float
        From :func:`way_left`.
    """
    end = 1.0 if turned > 0.0 else -1.0
    bent = end + (bend - end) * left
    return end if bent * end > SLIDING else bent


def held_bend(bend: float, free: float, per_friction: float, yield_angle: float) -> float:
    """Return the mean bend over a step, which tells the friction that is felt in it.

    Parameters
    ----------
    bend : float
        The bend before.
    free : float
        Angle by which the motor turns if the bend stays [rad].
    per_friction : float
        Angle by which the friction of a motor that slides turns it less in the step [rad].
    yield_angle : float
        Yield angle theta_y [rad].
    """
    end = 1.0 if free > 0.0 else -1.0
    room = 1.0 - end * bend
    if room == 0.0:
        return bend
    stiffness = per_friction * room / yield_angle
    # That of the end in the mean over the step, of a motor that settles evenly: 1/2 for soft
    # asperities, 1 for those that hold it within a part of the step.
    weight = (6.0 + stiffness * (3.0 + stiffness)) / (12.0 + stiffness * (4.0 + stiffness))
    most = weight * per_friction * room
    # At least as far as against the first stiffness, or all that may come. Friction grows ever more
    # slowly, so Newton's steps from there never go too far.
    turned = max(abs(free) / (1.0 + weight * stiffness), abs(free) - most)
    for _ in range(MOST_STEPS):
        left = way_left(turned, yield_angle)
        further = abs(free) - turned - most * (1.0 - left)
        further /= 1.0 + most * left / yield_angle
        if further <= NEGLIGIBLE * yield_angle:
            break
        turned += further
    left *= 1.0 - further / yield_angle
    return bend + weight * end * room * (1.0 - left)


def yielding_motor_step(
    motor: MotorState,
    voltage: float,
    loads: tuple[float, float, float],
    size: float,
    bend: float,
    yield_angle: float,
    step: ResistedMotor,
) -> MotorState:
    """Advance a motor with yielding friction by one step with `voltage` [V] held.

    It is stable however stiff the asperities are.

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
    bend : float
        Bend of the asperities at the beginning.
    yield_angle : float
        Yield angle theta_y [rad].
    step : ResistedMotor
        From :func:`bdt_plant.resisted_motor.discretize_resisted_motor`.
    """
    load, backward, forward = loads
    held = bend
    if abs(bend) < 1.0 or motor.speed * bend <= 0.0:
        first = resisted_motor_step(motor, voltage, load + size * bend, backward, forward, step)
        per_current = step.motor.angle[0] + step.resistance * step.motor.angle[2]
        free = first.angle - motor.angle
        if abs(free) <= STILL * yield_angle:
            return MotorState(first.current, 0.0, motor.angle)
        held = held_bend(bend, free, size * per_current, yield_angle)
    return resisted_motor_step(motor, voltage, load + size * held, backward, forward, step)
