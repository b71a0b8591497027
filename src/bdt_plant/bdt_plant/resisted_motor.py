"""The motor over one short step, against a resistance that is set-valued at rest.

Forward motion meets one torque, backward motion another, and at rest the resistance is whatever
between the two holds the motor: dry friction, and the load that a screw holds. As in
:mod:`bdt_plant.friction`, a torque that is held over the step is a motor without friction whose
current and voltage are others, so the linear part is exact. Held is the mean over the step: the
resistance of the direction, what it takes to stop, and a part of each where the motor turns back or
breaks loose. A motor that rests for the whole step is advanced exactly.

With resistances that are constant the error is of second order in the step; those that depend on
speed, angle or force are to be given for the middle of the step.
"""

from typing import NamedTuple

from bdt_plant.elementary_functions import float_exponential
from bdt_plant.friction import breakaway_friction, held_torque_step
from bdt_plant.motor import (
    SMALLEST_SIGNAL,
    DiscreteMotor,
    MotorParameters,
    MotorState,
    discretize_motor,
)


class ResistedMotor(NamedTuple):
    """A motor over one short step.

    Attributes
    ----------
    motor : DiscreteMotor
        Motor without resistance.
    resistance : float
        Resistance R of the armature [Ohm].
    decay : float
        What is left after one step of a current in a motor that stands still.
    per_current : float
        Speed at the end of the step per current held [rad/(s A)].
    """

    motor: DiscreteMotor
    resistance: float
    decay: float
    per_current: float


def discretize_resisted_motor(motor: MotorParameters, step_time: float) -> ResistedMotor:
    """Return a motor for steps of `step_time` [s]."""
    return resisted_motor(discretize_motor(motor, step_time), motor, step_time)


def resisted_motor(step: DiscreteMotor, motor: MotorParameters, step_time: float) -> ResistedMotor:
    """Return a motor whose discrete model without resistance is known.

    Parameters
    ----------
    step : DiscreteMotor
        Motor without resistance over one step.
    motor : MotorParameters
        Constants of the motor.
    step_time : float
        Time that a step takes [s].
    """
    resistance = float(motor.resistance)
    return ResistedMotor(
        step,
        resistance,
        float_exponential(-resistance * step_time / motor.inductance),
        step.speed[0] + resistance * step.speed[2],
    )


def resisted_motor_step(
    state: MotorState,
    voltage: float,
    load: float,
    backward: float,
    forward: float,
    step: ResistedMotor,
) -> MotorState:
    """Advance the motor by one step with `voltage` [V] held.

    Parameters
    ----------
    state : MotorState
        Motor at the beginning of the step.
    voltage : float
        Motor voltage u [V].
    load : float
        Torque against forward motion that is there whatever the motor does, as a current [A].
    backward, forward : float
        Resistance to motion backward and forward as currents [A]; their sum is not negative.
    step : ResistedMotor
        From :func:`discretize_resisted_motor`.
    """
    current, speed, angle = state
    torque = current - load
    sign = 0.0
    if speed > 0.0 or (speed == 0.0 and torque > forward):
        sign = 1.0
    elif speed < 0.0 or torque < -backward:
        sign = -1.0
    if sign == 0.0:
        # The motor rests at first, and may break loose within the step.
        end = step.decay * current + (1.0 - step.decay) * voltage / step.resistance
        if end - load > forward:
            held = breakaway_friction(torque, end - load, forward)
            moved = _moved(state, voltage, load + held, step)
            if moved.speed > 0.0:
                return moved
        elif end - load < -backward:
            held = -breakaway_friction(-torque, load - end, backward)
            moved = _moved(state, voltage, load + held, step)
            if moved.speed < 0.0:
                return moved
        if abs(end) < SMALLEST_SIGNAL:
            end = 0.0
        return MotorState(end, 0.0, angle)
    held, reverse = (forward, -backward) if sign > 0.0 else (-backward, forward)
    moved = _moved(state, voltage, load + held, step)
    if moved.speed * sign > 0.0:
        return moved
    # The motor stops. The resistance to the other direction tells whether it turns back.
    turned = moved.speed + (held - reverse) * step.per_current
    if (turned - speed) * sign >= 0.0:
        held += moved.speed / step.per_current
        stopped = _moved(state, voltage, load + held, step)
        return MotorState(stopped.current, 0.0, stopped.angle)
    before = speed / (speed - moved.speed) if speed != 0.0 else 0.0
    return _moved(state, voltage, load + held * before + reverse * (1.0 - before), step)


def _moved(state: MotorState, voltage: float, held: float, step: ResistedMotor) -> MotorState:
    """Advance the motor against the torque k_T `held` over the whole step."""
    return held_torque_step(state, voltage, held, step.resistance, step.motor).motor
