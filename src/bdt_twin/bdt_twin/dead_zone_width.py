"""Width of the controller's dead zone for an estimated gap (eq. 9)."""


def tolerance_for_gap(gap: float, pitch: float) -> float:
    """Return the dead-zone tolerance epsilon_dz = p theta_b [m] (eq. 9).

    Parameters
    ----------
    gap : float
        Estimated backlash gap theta_b [rad].
    pitch : float
        Pitch p of the lead screw [m/rad].
    """
    return pitch * max(gap, 0.0)
