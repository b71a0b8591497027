"""What is commanded: the PID in its dead zone, a filter in series, an offset and a limit; bumpless.

Whatever is reconfigured while the loop runs would make the voltage jump: a gain by what it adds to
the error and its integral, a dead zone by the whole voltage where the error is between the old and
the new one. So the voltage goes on from where it is, and the difference dies away: the *blend*.
"""

import math
from typing import NamedTuple

from bdt_controller.dead_zone import dead_zone_error, dead_zone_voltage
from bdt_controller.notch import (
    NO_NOTCH,
    NOTCH_AT_REST,
    DiscreteNotch,
    NotchFilter,
    NotchState,
    discretize_notch,
    notch_at,
    notch_step,
)
from bdt_controller.pid import (
    INITIAL_PID,
    DiscretePid,
    PidGains,
    PidState,
    decay,
    discretize_pid,
    pid_step,
)

BLEND_TIME = 0.05
"""Time constant with which the old voltage fades into the new one [s]: half of what the paper's
bandwidth of 10 rad/s stands for, so that the loop is done with a switch before it answers to it."""

SMALLEST_BLEND = 1e-9
"""Voltage [V] below which nothing is left of a switch."""

NOT_SET = -1.0
"""Tolerance of a controller that has not begun: what is set before is no switch."""


class ControlLaw(NamedTuple):
    """Discrete models of the controller's linear parts.

    Attributes
    ----------
    pid : DiscretePid
        PID (eq. 4).
    notch : DiscreteNotch
        Filter in series.
    blend_decay : float
        Share of the blend that is left after a control period.
    """

    pid: DiscretePid
    notch: DiscreteNotch
    blend_decay: float


class ControlState(NamedTuple):
    """State of the controller.

    Attributes
    ----------
    pid : PidState
        PID.
    notch : NotchState
        Filter in series.
    tolerance : float
        Dead-zone tolerance of the last step [m]; negative before the first.
    offset : float
        Voltage offset of the last step [V].
    blend : float
        Voltage that is left of switches before [V].
    """

    pid: PidState
    notch: NotchState
    tolerance: float
    offset: float
    blend: float


INITIAL_CONTROL = ControlState(INITIAL_PID, NOTCH_AT_REST, NOT_SET, 0.0, 0.0)


def discretize_control(gains: PidGains, period: float, notch: NotchFilter = NO_NOTCH) -> ControlLaw:
    """Return the discrete equivalents of PID and filter for a control `period` [s]."""
    # A gain written as 3000 is an int, for which nothing is compiled.
    pid = DiscretePid(*map(float, discretize_pid(gains, period)))
    return ControlLaw(pid, discretize_notch(notch, period), decay(period, BLEND_TIME))


def unlimited_step(
    state: ControlState, error: float, tolerance: float, law: ControlLaw, offset: float
) -> tuple[PidState, NotchState, float]:
    """Advance PID and filter by one control period (eqs 5, 7 and 8), without limit and blend.

    In the dead zone the voltage is the offset alone, and the integral stands still (eq. 8).

    Parameters
    ----------
    state : ControlState
        State before.
    error : float
        Tracking error e = r - q3 [m].
    tolerance : float
        Dead-zone tolerance epsilon_dz [m]; zero switches the dead zone off.
    law : ControlLaw
        From :func:`discretize_control`.
    offset : float
        Voltage added to every command, in the dead zone as well [V].

    Returns
    -------
    pid : PidState
        State of the PID after.
    notch : NotchState
        State of the filter after.
    voltage : float
        u_dz + offset [V].
    """
    pid, voltage = pid_step(state.pid, dead_zone_error(error, tolerance), law.pid)
    notch = state.notch
    if law.notch.is_on:
        notch, voltage = notch_step(notch, voltage, law.notch)
    voltage = dead_zone_voltage(voltage, error, tolerance)
    # Without one the very bits stay: -0.0 + 0.0 is 0.0.
    if offset != 0.0:
        voltage += offset
    return pid, notch, voltage


def control_step(
    state: ControlState,
    error: float,
    tolerance: float,
    law: ControlLaw,
    limit: float = 0.0,
    offset: float = 0.0,
) -> tuple[ControlState, float]:
    """Advance the controller by one control period.

    While the voltage is limited, an error that would drive it further beyond the limit is not
    integrated (conditional integration; Åström and Hägglund, Advanced PID Control, 3.5). With
    `limit` and `offset` zero, no filter and nothing reconfigured this is eqs 5, 7 and 8 alone.

    Parameters
    ----------
    state : ControlState
        State before.
    error : float
        Tracking error e = r - q3 [m].
    tolerance : float
        Dead-zone tolerance epsilon_dz [m]; zero switches the dead zone off.
    law : ControlLaw
        From :func:`discretize_control`.
    limit : float
        Largest voltage of either sign [V]; zero for none.
    offset : float
        Voltage added to every command, in the dead zone as well [V].

    Returns
    -------
    state : ControlState
        State after.
    voltage : float
        u_dz + offset + blend within the limit [V].
    """
    pid, notch, voltage = unlimited_step(state, error, tolerance, law, offset)
    blend = state.blend
    if state.tolerance >= 0.0 and (tolerance != state.tolerance or offset != state.offset):
        _, _, before = unlimited_step(state, error, state.tolerance, law, state.offset)
        blend += before - voltage
    if blend != 0.0:
        voltage += blend
        blend *= law.blend_decay
        if abs(blend) < SMALLEST_BLEND:
            blend = 0.0
    if limit > 0.0 and abs(voltage) > limit:
        if law.pid.integral * error * voltage > 0.0:
            pid = PidState(state.pid.integral, pid.filtered)
        voltage = math.copysign(limit, voltage)
    return ControlState(pid, notch, tolerance, offset, blend), voltage


def switched(
    state: ControlState, error: float, before: ControlLaw, after: ControlLaw
) -> ControlState:
    """Return the state with which another law goes on from the voltage of the one before.

    The integral's voltage is carried over, and so are the derivative's filter and the filter in
    series. What the voltages still differ by goes into the blend.

    Parameters
    ----------
    state : ControlState
        State before the step in which the other law takes over.
    error : float
        Tracking error of that step [m].
    before, after : ControlLaw
        The laws.
    """
    if state.tolerance < 0.0:
        return state
    _, _, old = unlimited_step(state, error, state.tolerance, before, state.offset)
    pid, notch = state.pid, state.notch
    if after.pid.integral != 0.0:
        pid = PidState(pid.integral * (before.pid.integral / after.pid.integral), pid.filtered)
    state = state._replace(pid=pid)
    if after.notch.is_on and not before.notch.is_on:
        _, through = pid_step(pid, dead_zone_error(error, state.tolerance), after.pid)
        notch = notch_at(through)
    state = state._replace(notch=notch)
    _, _, new = unlimited_step(state, error, state.tolerance, after, state.offset)
    return state._replace(blend=state.blend + (old - new))
