"""The closed loop as a user of python-control would write it: a yardstick for time and error."""

import numpy as np
from control import (
    InterconnectedSystem,
    NonlinearIOSystem,
    StateSpace,
    input_output_response,
    interconnect,
    nlsys,
    summing_junction,
)
from numpy.typing import NDArray

from bdt_controller.pid import PidGains
from bdt_plant.motor import motor_state_space
from bdt_plant.plant import PlantModel
from bdt_study.design.linear_model import pid_model, structure_model

FloatArray = NDArray[np.float64]


def interconnected_loop(model: PlantModel, gains: PidGains, gap: float) -> InterconnectedSystem:
    """Return the loop of figure 3 in continuous time, from the reference r [m] to q3 [m].

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism.
    gains : PidGains
        Gains of eq. 4; the controller is not sampled.
    gap : float
        Constant backlash gap theta_b [rad].
    """
    a, b = motor_state_space(model.motor)
    motor = StateSpace(
        a, b, [[0, 1, 0], [0, 0, 1]], 0, inputs=["u"], outputs=["omega_m", "theta_m"]
    )
    error = summing_junction(["r", "-q3"], "e")
    blocks = [
        error,
        pid_model(gains),
        motor,
        _backlash(model.lead_screw.pitch, gap),
        structure_model(model.structure),
    ]
    # Named by hand: systems without a name count up, and a warning follows.
    for block, name in zip(blocks, ("error", "pid", "motor", "screw", "structure"), strict=True):
        block.name = name
    return interconnect(blocks, inputs=["r"], outputs=["q3"], name="loop")


def step_response(
    loop: InterconnectedSystem,
    level: float,
    times: FloatArray,
    method: str,
    relative_tolerance: float = 1e-3,
) -> FloatArray:
    """Return q3 [m] after a step of the reference, by ``control.input_output_response``.

    Parameters
    ----------
    loop : control.InterconnectedSystem
        From :func:`interconnected_loop`.
    level : float
        Reference r [m].
    times : ndarray, shape (n,)
        Equidistant times from 0 [s].
    method : str
        Method of ``scipy.integrate.solve_ivp``.
    relative_tolerance : float
        Its rtol; the default is that of scipy. Its atol is a thousandth of it.

    Returns
    -------
    ndarray, shape (n,)
        Position q3 of platform 3 [m].
    """
    response = input_output_response(
        loop,
        times,
        np.full(times.size, level),
        solve_ivp_method=method,
        solve_ivp_kwargs={"rtol": relative_tolerance, "atol": 1e-3 * relative_tolerance},
    )
    return np.asarray(response.outputs, dtype=np.float64).ravel()


def _backlash(pitch: float, gap: float) -> NonlinearIOSystem:
    """Return eqs 1 and 6 as they are printed, from (omega_m, theta_m) to d [m]."""

    def screw_speed(
        _time: float, x: FloatArray, u: FloatArray, _params: dict[str, float]
    ) -> FloatArray:
        speed, play = u[0], u[1] - x[0]
        touches = (speed > 0 and play >= gap / 2) or (speed < 0 and play <= -gap / 2)
        return np.array([speed if touches else 0.0])

    def position(
        _time: float, x: FloatArray, _u: FloatArray, _params: dict[str, float]
    ) -> FloatArray:
        return pitch * x

    return nlsys(
        screw_speed, position, inputs=["omega_m", "theta_m"], outputs=["d"], states=["theta_d"]
    )
