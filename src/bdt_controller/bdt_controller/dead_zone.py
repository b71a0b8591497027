"""Switched dead zone around the PID (eqs 7 and 8)."""

from bdt_controller.pid import DiscretePid, PidState, pid_step


def dead_zone_error(error: float, tolerance: float) -> float:
    """Return e_dz of eq. 8: the error outside the dead zone, zero inside and on its edge.

    Parameters
    ----------
    error : float
        Tracking error e [m].
    tolerance : float
        Dead-zone tolerance epsilon_dz [m]; zero switches the dead zone off.
    """
    return error if abs(error) > tolerance else 0.0


def dead_zone_pid_step(
    state: PidState, error: float, tolerance: float, step: DiscretePid
) -> tuple[PidState, float]:
    """Advance the dead-zone PID by one control period (eqs 7 and 8).

    With `tolerance` zero this is the linear controller of eq. 5, also at the instant at which the
    error is exactly zero (a quantised measurement makes that frequent).

    Returns
    -------
    state : PidState
        State after.
    voltage : float
        u_dz [V].
    """
    following, voltage = pid_step(state, dead_zone_error(error, tolerance), step)
    if tolerance > 0.0 and abs(error) <= tolerance:
        return following, 0.0
    return following, voltage
