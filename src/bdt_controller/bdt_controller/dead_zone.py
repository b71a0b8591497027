"""Switched dead zone around the PID (eqs 7 and 8)."""


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


def dead_zone_voltage(voltage: float, error: float, tolerance: float) -> float:
    """Return u_dz of eq. 7: the controller's voltage outside the dead zone, zero inside.

    With `tolerance` zero this is the linear controller of eq. 5, also at the instant at which the
    error is exactly zero (a quantized measurement makes that frequent).

    Parameters
    ----------
    voltage : float
        C(s) e_dz [V].
    error : float
        Tracking error e [m].
    tolerance : float
        Dead-zone tolerance epsilon_dz [m]; zero switches the dead zone off.
    """
    return 0.0 if tolerance > 0.0 and abs(error) <= tolerance else voltage
