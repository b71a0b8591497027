"""A mechanism with what the paper leaves out: friction that is not Coulomb's, loads, pushes.

The paper's mechanism has an exact discrete model (:mod:`bdt_plant.plant`). What is not linear has
not, so each sample is cut into steps. Motor and tower are advanced by their exact linear maps;
forces and torques that are not linear are held over a step at their value in the middle of it. Dry
friction is set-valued, as it is there. The error is of second order in the step, but for two things
of first order: a contact or a motion that begins within a step, and the beams' damping in the load
through a rigid screw, which is that of the beginning.
"""

from typing import NamedTuple

from bdt_plant.amplifier_lag import DiscreteLag, discretize_lag
from bdt_plant.cogging import Cogging, cogging_current, cogging_of
from bdt_plant.lead_screw import contact_side, play, screw_end
from bdt_plant.motor import MotorState
from bdt_plant.plant import FloatArray, PlantModel, Sampling
from bdt_plant.pushes import Pushes, discretize_pushes, push_force
from bdt_plant.resisted_motor import (
    ResistedMotor,
    discretize_resisted_motor,
    resisted_motor_step,
)
from bdt_plant.screw_load import ScrewLoad, backward_load, forward_load, screw_load
from bdt_plant.stiffening_tower import (
    DiscreteTower,
    TowerState,
    discretize_tower,
    screw_force,
    tower_step,
)
from bdt_plant.stribeck import FrictionLaw, friction_law, friction_size


class DiscreteMachine(NamedTuple):
    """Discrete model of a mechanism that is not linear.

    Attributes
    ----------
    sub_steps : int
        Steps in one sample.
    motor : ResistedMotor
        Motor.
    friction : FrictionLaw
        Its friction.
    cogging : Cogging
        Its cogging.
    load : ScrewLoad
        What it feels of the tower.
    tower : DiscreteTower
        Structure, with the elasticity of the screw.
    pushes : Pushes
        Pushes on a platform.
    pitch : float
        Pitch p of the lead screw [m/rad].
    half_step : float
        Half of a step [s].
    thread_error : float
        Amplitude of the error of the screw's thread [m]; 0 for none.
    lag : DiscreteLag
        How late the amplifier is.
    """

    sub_steps: int
    motor: ResistedMotor
    friction: FrictionLaw
    cogging: Cogging
    load: ScrewLoad
    tower: DiscreteTower
    pushes: Pushes
    pitch: float
    half_step: float
    thread_error: float
    lag: DiscreteLag


class MachineState(NamedTuple):
    """State of a mechanism that is not linear.

    Attributes
    ----------
    motor : MotorState
        Motor.
    theta_d : float
        Angle of the lead screw [rad].
    contact : int
        1 or -1 while the motor drives the screw forward or backward, 0 inside the gap.
    structure : TowerState
        Platforms 1 to 3.
    sample : int
        Number of the sample, which pushes depend on.
    voltage : float
        Voltage of the motor [V].
    """

    motor: MotorState
    theta_d: float
    contact: int
    structure: TowerState
    sample: int
    voltage: float


MACHINE_AT_REST = MachineState(
    MotorState(0.0, 0.0, 0.0), 0.0, 0, TowerState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), 0, 0.0
)
"""Everything at zero, the motor in the middle of the gap."""


def discretize_machine(model: PlantModel, sampling: Sampling) -> DiscreteMachine:
    """Return the discrete model of a mechanism that is not linear."""
    motor, pitch = model.motor, float(model.lead_screw.pitch)
    step_time = 1.0 / sampling.sampling_rate / sampling.sub_steps
    return DiscreteMachine(
        int(sampling.sub_steps),
        discretize_resisted_motor(motor, step_time),
        friction_law(motor, model.stribeck),
        cogging_of(motor, model.cogging),
        screw_load(model.screw_mechanics, pitch, motor.torque_constant),
        discretize_tower(model.structure, model.beams, model.screw_mechanics.stiffness, step_time),
        discretize_pushes(model.pushes, sampling.sampling_rate),
        pitch,
        0.5 * step_time,
        float(model.screw_mechanics.thread_error),
        discretize_lag(model.amplifier, step_time),
    )


def machine_step(
    state: MachineState, voltage: float, gap: float, step: DiscreteMachine
) -> MachineState:
    """Advance a mechanism by one sample (eqs 1, 2, 3, 6 and what the paper leaves out).

    Parameters
    ----------
    state : MachineState
        State at the beginning of the sample.
    voltage : float
        Voltage that the amplifier is told to give [V], held over the sample.
    gap : float
        Backlash gap theta_b [rad] at the end of the sample.
    step : DiscreteMachine
        From :func:`discretize_machine`.
    """
    motor, theta_d, contact, tower, sample, applied = state
    push = push_force(sample, step.pushes)
    push_2, push_3 = (push, 0.0) if step.pushes.platform == 2 else (0.0, push)
    after = screw_end(theta_d, step.pitch, step.thread_error)
    for _ in range(step.sub_steps):
        before, off = after, applied - voltage
        applied, mean = voltage + step.lag.kept * off, voltage + step.lag.mean * off
        motor = _motor_step(motor, mean, before, contact, gap, tower, step)
        theta_d = play(theta_d, motor.angle, gap)
        contact = contact_side(theta_d, motor.angle, gap)
        after = screw_end(theta_d, step.pitch, step.thread_error)
        tower = tower_step(tower, before, after, push_2, push_3, step.tower)
    return MachineState(motor, theta_d, contact, tower, sample + 1, applied)


def _motor_step(
    motor: MotorState,
    voltage: float,
    d: float,
    contact: int,
    gap: float,
    tower: TowerState,
    step: DiscreteMachine,
) -> MotorState:
    """Advance the motor by one step against cogging, load and friction."""
    forward = backward = 0.0
    if step.load.against > 0.0 and contact != 0:
        d_velocity = step.pitch * motor.speed
        force = screw_force(tower, d, d_velocity, step.tower)
        forward = forward_load(force, contact, gap, step.load)
        backward = backward_load(force, contact, gap, step.load)
    load = cogging_current(motor.angle + step.half_step * motor.speed, step.cogging)
    loads = (load, backward, forward)
    size = friction_size(motor.speed, step.friction)
    moved = _step_against_friction(motor, voltage, loads, size, step)
    if step.friction.excess == 0.0 or motor.speed * moved.speed <= 0.0:
        return moved
    # Again with the friction of the speed in the middle of the step.
    size = friction_size(0.5 * (motor.speed + moved.speed), step.friction)
    return _step_against_friction(motor, voltage, loads, size, step)


def _step_against_friction(
    motor: MotorState,
    voltage: float,
    loads: tuple[float, float, float],
    size: float,
    step: DiscreteMachine,
) -> MotorState:
    """Advance the motor by one step against (load, backward, forward) and friction of a size."""
    load, backward, forward = loads
    return resisted_motor_step(
        motor,
        voltage,
        load,
        backward + step.friction.backward * size,
        forward + step.friction.forward * size,
        step.motor,
    )


def first_platform_of_machine(state: MachineState, _step: DiscreteMachine) -> float:
    """Return the position of platform 1, which an elastic screw does not fix [m]."""
    return state.structure.q1


def hold_machine_period(
    state: MachineState,
    voltage: float,
    gaps: FloatArray,
    step: DiscreteMachine,
    positions: FloatArray,
) -> MachineState:
    """Advance a mechanism by some samples with one voltage held.

    Parameters and result are those of :func:`bdt_plant.plant.hold_period`.
    """
    for n in range(gaps.size):
        state = machine_step(state, voltage, float(gaps[n]), step)
        positions[n] = state.structure.q3
    return state
