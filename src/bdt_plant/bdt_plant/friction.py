"""Coulomb friction of the motor: a torque of given size against the motion, and stiction.

A friction torque tau that is constant over a sample is nothing but another motor without friction:
with the current i - tau / k_T and the voltage u - R tau / k_T in eq. 2 the speed is the same. So
friction needs no model of its own, only the torque to hold over the sample. It is the mean of the
friction over the sample: against the motion as long as the motor turns, what it takes to stop where
it sticks, and a part of each where it turns back or breaks loose within the sample. The instants
are found from a straight line between the ends of the sample, so the error of angle and speed is of
second order in the sample time. A motor that sticks for a whole sample is advanced exactly.
"""

import math
from typing import NamedTuple

from bdt_plant.elementary_functions import float_exponential
from bdt_plant.motor import SMALLEST_SIGNAL, DiscreteMotor, MotorParameters, MotorState, motor_step


class DiscreteFriction(NamedTuple):
    """Coulomb friction over one sample.

    Attributes
    ----------
    current : float
        Current whose torque equals the friction, tau_C / k_T [A]; 0 for none.
    resistance : float
        Resistance R of the armature [Ohm].
    decay : float
        What is left after one sample of a current in a motor that stands still.
    """

    current: float
    resistance: float
    decay: float


class FrictionalMotion(NamedTuple):
    """One sample of a motor with friction.

    Attributes
    ----------
    motor : MotorState
        Motor at the end of the sample.
    driver : MotorState
        Motor without friction that moves alike, at the beginning of the sample.
    driver_voltage : float
        Its voltage [V].
    """

    motor: MotorState
    driver: MotorState
    driver_voltage: float


def discretize_friction(motor: MotorParameters, sample_time: float) -> DiscreteFriction:
    """Return the friction of a motor over one sample.

    Parameters
    ----------
    motor : MotorParameters
        Constants of the motor.
    sample_time : float
        Sample time [s].
    """
    return DiscreteFriction(
        float(motor.coulomb_friction / motor.torque_constant),
        float(motor.resistance),
        float_exponential(-motor.resistance * sample_time / motor.inductance),
    )


def friction_voltage(motor: MotorParameters) -> float:
    """Return the voltage that the Coulomb friction of a motor takes, R tau_C / k_T [V]."""
    return motor.coulomb_friction / motor.torque_constant * motor.resistance


def frictional_motor_step(
    state: MotorState, voltage: float, step: DiscreteMotor, friction: DiscreteFriction
) -> FrictionalMotion:
    """Advance a motor with Coulomb friction by one sample with `voltage` [V] held.

    Parameters
    ----------
    state : MotorState
        Motor at the beginning of the sample.
    voltage : float
        Motor voltage u [V].
    step : DiscreteMotor
        From :func:`bdt_plant.motor.discretize_motor`.
    friction : DiscreteFriction
        From :func:`discretize_friction`; its current is not zero.
    """
    current, speed, angle = state
    if speed == 0.0:
        end = friction.decay * current + (1.0 - friction.decay) * voltage / friction.resistance
        if abs(current) <= friction.current and abs(end) <= friction.current:
            if abs(end) < SMALLEST_SIGNAL:
                end = 0.0
            at_rest = MotorState(0.0, 0.0, angle)
            return FrictionalMotion(MotorState(end, 0.0, angle), at_rest, 0.0)
        direction = math.copysign(1.0, current if abs(current) > friction.current else end)
        held = breakaway_friction(direction * current, direction * end, friction.current)
        held *= direction
    else:
        held = math.copysign(friction.current, speed)
    moved = held_torque_step(state, voltage, held, friction.resistance, step)
    if moved.motor.speed * held > 0.0:
        return moved
    # The motor stops. The opposite friction tells whether it can start again.
    per_current = step.speed[0] + friction.resistance * step.speed[2]
    reverse = moved.motor.speed + 2.0 * held * per_current
    if (reverse - speed) * held >= 0.0:
        held += moved.motor.speed / per_current
        stopped = held_torque_step(state, voltage, held, friction.resistance, step)
        motor = MotorState(stopped.motor.current, 0.0, stopped.motor.angle)
        return FrictionalMotion(motor, stopped.driver, stopped.driver_voltage)
    before_the_turn = speed / (speed - moved.motor.speed)
    held *= 2.0 * before_the_turn - 1.0
    return held_torque_step(state, voltage, held, friction.resistance, step)


def breakaway_friction(begin: float, end: float, limit: float) -> float:
    """Return the mean friction over a step in which the motor breaks loose forward [A].

    Parameters
    ----------
    begin, end : float
        Torque at the ends of the step if the motor stood still, as a current [A]; one of them is
        above the limit.
    limit : float
        Current whose torque equals the friction [A].
    """
    if begin > limit:
        return limit
    standing = (limit - begin) / (end - begin)
    # While it stands, friction balances the torque, which grows to the limit.
    return standing * 0.5 * (begin + limit) + (1.0 - standing) * limit


def held_torque_step(
    state: MotorState, voltage: float, held: float, resistance: float, step: DiscreteMotor
) -> FrictionalMotion:
    """Advance the motor against a torque that is held over the whole step.

    Parameters
    ----------
    state : MotorState
        Motor at the beginning of the step.
    voltage : float
        Motor voltage u [V].
    held : float
        Current whose torque is held against the motor [A].
    resistance : float
        Resistance R of the armature [Ohm].
    step : DiscreteMotor
        From :func:`bdt_plant.motor.discretize_motor`.
    """
    driver = MotorState(state.current - held, state.speed, state.angle)
    driver_voltage = voltage - resistance * held
    current, speed, angle = motor_step(driver, driver_voltage, step)
    return FrictionalMotion(MotorState(current + held, speed, angle), driver, driver_voltage)
