"""DC motor (eq. 2 of the paper), discretised exactly for a voltage held over the sample."""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.quantities import quantity, validate
from bdt_plant.matrix_exponential import Exponential, matrix_exponential

SMALLEST_SIGNAL = 1e-30
"""A decaying current [A] or speed [rad/s] below this is zero: subnormal floats are slow."""


@dataclass(frozen=True)
class MotorParameters:
    """Constants of the DC motor (table 1)."""

    inertia: float = quantity(5e-6, "kg m^2", "inertia J of the rotor", minimum=1e-12, maximum=1e3)
    inductance: float = quantity(
        1e-3, "H", "inductance L of the armature", minimum=1e-9, maximum=1e2
    )
    resistance: float = quantity(
        12.0, "Ohm", "resistance R of the armature", minimum=1e-6, maximum=1e6
    )
    torque_constant: float = quantity(
        0.8, "N m/A", "torque constant k_T", minimum=1e-9, maximum=1e6
    )
    back_emf_constant: float = quantity(
        0.1, "V s/rad", "back-EMF constant k_B", minimum=1e-9, maximum=1e6
    )
    viscous_friction: float = quantity(
        0.0, "N m s/rad", "friction torque per speed, not in the paper", minimum=0.0, maximum=1e3
    )
    coulomb_friction: float = quantity(
        0.0,
        "N m",
        "friction torque of a turning motor, and the largest of a standing one; not in the paper",
        minimum=0.0,
        maximum=1e3,
        reconfigurable=True,
    )

    def __post_init__(self) -> None:
        validate(self)


class MotorState(NamedTuple):
    """State of the motor: current i [A], speed omega_m [rad/s], angle theta_m [rad]."""

    current: float
    speed: float
    angle: float


class DiscreteMotor(NamedTuple):
    """Rows of the exact one-sample map; each row multiplies (current, speed, voltage).

    The row of the angle gives the increment of the angle over the sample.
    """

    current: tuple[float, float, float]
    speed: tuple[float, float, float]
    angle: tuple[float, float, float]


def motor_state_space(motor: MotorParameters) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the continuous model behind eq. 2: L di/dt = u - R i - k_B w, J dw/dt = k_T i - b w.

    The viscous friction b is zero in the paper. Coulomb friction is not linear and not in here,
    see :mod:`bdt_plant.friction`.

    Returns
    -------
    a : ndarray, shape (3, 3)
        State matrix for (i [A], omega_m [rad/s], theta_m [rad]).
    b : ndarray, shape (3, 1)
        Input matrix for the voltage u [V].
    """
    a = np.array(
        [
            [-motor.resistance / motor.inductance, -motor.back_emf_constant / motor.inductance, 0],
            [motor.torque_constant / motor.inertia, -motor.viscous_friction / motor.inertia, 0],
            [0, 1, 0],
        ],
        dtype=np.float64,
    )
    b = np.array([[1 / motor.inductance], [0], [0]], dtype=np.float64)
    return a, b


@lru_cache(maxsize=256)
def discretize_motor(
    motor: MotorParameters, sample_time: float, exponential: Exponential = matrix_exponential
) -> DiscreteMotor:
    """Return the zero-order-hold equivalent of eq. 2, by a matrix exponential.

    Parameters
    ----------
    motor : MotorParameters
        Constants of the motor.
    sample_time : float
        Sample time [s].
    exponential : callable
        Returns the exponential of a matrix.
    """
    a, b = motor_state_space(motor)
    held = np.zeros((4, 4))
    held[:3, :3], held[:3, 3:] = a, b
    one_sample = exponential(held * sample_time)
    rows = [tuple(float(x) for x in one_sample[row, [0, 1, 3]]) for row in range(3)]
    return DiscreteMotor(*rows)  # type: ignore[arg-type]


def motor_step(state: MotorState, voltage: float, step: DiscreteMotor) -> MotorState:
    """Advance the motor without Coulomb friction by one sample with `voltage` [V] held (eq. 2)."""
    current, speed, angle = state
    i_i, i_w, i_u = step.current
    w_i, w_w, w_u = step.speed
    a_i, a_w, a_u = step.angle
    next_current = i_i * current + i_w * speed + i_u * voltage
    next_speed = w_i * current + w_w * speed + w_u * voltage
    next_angle = angle + (a_i * current + a_w * speed + a_u * voltage)
    if abs(next_current) < SMALLEST_SIGNAL:
        next_current = 0.0
    if abs(next_speed) < SMALLEST_SIGNAL:
        next_speed = 0.0
    return MotorState(next_current, next_speed, next_angle)
