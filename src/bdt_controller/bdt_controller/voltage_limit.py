"""What is commanded: the PID's voltage with an offset, limited so that nothing winds up."""

import math

from bdt_controller.dead_zone import dead_zone_pid_step
from bdt_controller.pid import DiscretePid, PidState


def limited_pid_step(
    state: PidState,
    error: float,
    tolerance: float,
    step: DiscretePid,
    limit: float,
    offset: float = 0.0,
) -> tuple[PidState, float]:
    """Advance the dead-zone PID by one control period, add an offset and limit the sum.

    While the voltage is limited, an error that would drive it further beyond the limit is not
    integrated (conditional integration; Åström and Hägglund, Advanced PID Control, 3.5). With
    `limit` and `offset` zero this is eqs 5, 7 and 8 alone.

    Parameters
    ----------
    state : PidState
        State before.
    error : float
        Tracking error e = r - q3 [m].
    tolerance : float
        Dead-zone tolerance epsilon_dz [m]; zero switches the dead zone off.
    step : DiscretePid
        From :func:`bdt_controller.pid.discretize_pid`.
    limit : float
        Largest voltage of either sign [V]; zero for none.
    offset : float
        Voltage added to every command, in the dead zone as well [V].

    Returns
    -------
    state : PidState
        State after.
    voltage : float
        u_dz + offset within the limit [V].
    """
    following, voltage = dead_zone_pid_step(state, error, tolerance, step)
    # Without one the very bits stay: -0.0 + 0.0 is 0.0.
    if offset != 0.0:
        voltage += offset
    if limit == 0.0 or abs(voltage) <= limit:
        return following, voltage
    if step.integral * error * voltage > 0.0:
        following = PidState(state.integral, following.filtered)
    return following, math.copysign(limit, voltage)
