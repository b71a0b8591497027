"""Linear models of eqs 2, 3 and 4 for python-control, and the loop they make without backlash.

Everything is built from the state spaces of the cores in ``bdt_plant`` and from the step function
of the control law in ``bdt_controller``: these are the one implementation of each equation. All
models are :class:`control.StateSpace`; ``control.tf`` of one gives the fraction that the paper
prints.
"""

import numpy as np
from control import StateSpace, feedback, sample_system
from numpy.typing import NDArray

from bdt_controller.control_law import INITIAL_CONTROL, discretize_control, unlimited_step
from bdt_controller.notch import NO_NOTCH, NotchFilter, NotchState
from bdt_controller.pid import PidGains, PidState
from bdt_plant.motor import MotorParameters, motor_state_space
from bdt_plant.plant import PlantModel
from bdt_plant.structure import StructureParameters, structure_state_space

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def motor_model(motor: MotorParameters) -> StateSpace:
    """Return eq. 2, from the voltage u [V] to the angle theta_m [rad].

    Parameters
    ----------
    motor : MotorParameters
        Constants of the motor.

    Returns
    -------
    control.StateSpace
        States (i [A], omega_m [rad/s], theta_m [rad]).
    """
    a, b = motor_state_space(motor)
    return StateSpace(a, b, [[0, 0, 1]], 0, inputs=["u"], outputs=["theta_m"])


def structure_model(structure: StructureParameters) -> StateSpace:
    """Return eq. 3, from the position d [m] of the lead screw's end to q3 [m].

    The core is driven by d and d': x' = A x + b1 d + b2 d'. With z = x - b2 d the derivative of
    the input disappears: z' = A z + (b1 + A b2) d.

    Parameters
    ----------
    structure : StructureParameters
        Constants of the structure.

    Returns
    -------
    control.StateSpace
        Four states, those of the core less b2 d.
    """
    a, b = structure_state_space(structure)
    top = np.array([[0.0, 0.0, 1.0, 0.0]])
    shifted = b[:, :1] + a @ b[:, 1:]
    return StateSpace(a, shifted, top, top @ b[:, 1:], inputs=["d"], outputs=["q3"])


def pid_model(gains: PidGains) -> StateSpace:
    """Return eq. 4, from the error e [m] to the voltage u [V].

    Parameters
    ----------
    gains : PidGains
        Gains of eq. 4.

    Returns
    -------
    control.StateSpace
        States as in :class:`bdt_controller.pid.PidState`.
    """
    corner = 1.0 / gains.filter_time
    derivative = gains.derivative * corner
    return StateSpace(
        [[0, 0], [0, -corner]],
        [[1], [corner]],
        [[gains.integral, -derivative]],
        gains.proportional + derivative,
        inputs=["e"],
        outputs=["u"],
    )


def notch_model(notch: NotchFilter) -> StateSpace:
    """Return the filter in series with eq. 4, from the PID's voltage [V] to u [V].

    Parameters
    ----------
    notch : NotchFilter
        The filter.

    Returns
    -------
    control.StateSpace
        States as in :class:`bdt_controller.notch.NotchState`; none without a filter.
    """
    w = notch.frequency
    if w == 0.0:
        return StateSpace([], [], [], [[1.0]])
    depth = 2.0 * (notch.pole_damping - notch.zero_damping) / w
    a = np.array([[0.0, 1.0], [-w * w, -2.0 * notch.pole_damping * w]])
    b = np.array([[0.0], [w * w]])
    return StateSpace(a, b, [[0.0, -depth]], 1.0, inputs=["v"], outputs=["u"])


def plant_model(model: PlantModel) -> StateSpace:
    """Return eqs 1, 2 and 3 in a row with theta_d = theta_m, from u [V] to q3 [m].

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism.
    """
    return structure_model(model.structure) * (model.lead_screw.pitch * motor_model(model.motor))


def loop_transfer(model: PlantModel, gains: PidGains, notch: NotchFilter = NO_NOTCH) -> StateSpace:
    """Return the loop transfer function L = N C_PID p G1 G2, from e [m] to q3 [m] (eqs 1 to 5).

    It is also the loop around the backlash: cut open between theta_m and theta_d, the linear part
    from theta_d to theta_m is -L.

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism.
    gains : PidGains
        Gains of eq. 4.
    notch : NotchFilter
        Filter in series; none by default.
    """
    if notch.frequency == 0.0:
        return plant_model(model) * pid_model(gains)
    return plant_model(model) * notch_model(notch) * pid_model(gains)


def sampled_loop_transfer(
    model: PlantModel, gains: PidGains, control_rate: float, notch: NotchFilter = NO_NOTCH
) -> StateSpace:
    """Return the loop as the controller node closes it: control law of the core, voltage held.

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism.
    gains : PidGains
        Gains of eq. 4.
    control_rate : float
        Rate of measurements [Hz].
    notch : NotchFilter
        Filter in series; none by default.

    Returns
    -------
    control.StateSpace
        In discrete time; exact at the instants of measurement.
    """
    period = 1.0 / control_rate
    return sample_system(plant_model(model), period, "zoh") * _sampled_control(gains, notch, period)


def closed_loop(loop: StateSpace) -> StateSpace:
    """Return T = L / (1 + L), from the reference r [m] to q3 [m].

    Parameters
    ----------
    loop : control.StateSpace
        L, in continuous or discrete time.
    """
    return feedback(loop, 1)


def closed_loop_poles(loop: StateSpace) -> ComplexArray:
    """Return the poles of T = L / (1 + L), shape (states of L,).

    Those of ``closed_loop(loop)``, without making a system of it: a design asks thousands of times.

    Parameters
    ----------
    loop : control.StateSpace
        L, in continuous or discrete time.
    """
    feedthrough = float(loop.D[0, 0])
    return np.asarray(np.linalg.eigvals(loop.A - loop.B @ loop.C / (1.0 + feedthrough)))


def is_stable(loop: StateSpace) -> bool:
    """Tell whether the closed loop of `loop` is asymptotically stable.

    Parameters
    ----------
    loop : control.StateSpace
        L, in continuous or discrete time.
    """
    poles = closed_loop_poles(loop)
    return bool((abs(poles) < 1).all() if loop.isdtime(strict=True) else (poles.real < 0).all())


def frequency_response(system: StateSpace, frequency: FloatArray) -> ComplexArray:
    """Return the response of a system with one input and one output.

    All frequencies are solved for at once, which python-control does one after the other.

    Parameters
    ----------
    system : control.StateSpace
        In continuous or discrete time.
    frequency : ndarray, shape (n,)
        Angular frequencies [rad/s]; up to the Nyquist frequency in discrete time.

    Returns
    -------
    ndarray, shape (n,)
        Complex response.
    """
    point = 1j * frequency
    if system.isdtime(strict=True):
        point = np.exp(point * system.dt)
    resolvents = point[:, None, None] * np.eye(system.nstates) - system.A
    states = np.linalg.solve(resolvents, system.B[None].astype(np.complex128))
    return np.asarray((system.C @ states + system.D)[:, 0, 0], dtype=np.complex128)


def _sampled_control(gains: PidGains, notch: NotchFilter, period: float) -> StateSpace:
    """Return the core's law as a discrete system: the columns are its answers to unit vectors."""
    law = discretize_control(gains, period, notch)
    states = 4 if law.notch.is_on else 2
    columns = []
    for unit in np.eye(5)[[*range(states), 4]].tolist():
        integral, filtered, low_pass, rate, error = unit
        state = INITIAL_CONTROL._replace(
            pid=PidState(integral, filtered), notch=NotchState(low_pass, rate)
        )
        pid, filter_state, voltage = unlimited_step(state, error, 0.0, law, 0.0)
        columns.append([*[*pid, *filter_state][:states], voltage])
    answers = np.array(columns).T
    a, b = answers[:states, :states], answers[:states, states:]
    return StateSpace(a, b, answers[states:, :states], answers[states:, states:], period)
