"""PID with filtered derivative (eqs 4 and 5), one control step at a time."""

from dataclasses import dataclass
from decimal import Context, Decimal
from typing import NamedTuple

from bdt_msgs_py.quantities import quantity, validate

SMALLEST_SIGNAL = 1e-30
"""A decaying filter state [m] below this is zero: subnormal floats are slow."""

_DECIMAL = Context(prec=40)
# Rounded correctly, as the exponential function of the C library is not: its last bit differs from
# one computer to the next.


@dataclass(frozen=True)
class PidGains:
    """Gains of eq. 4; the paper leaves them open.

    The defaults put the first gain crossover at 10 rad/s with a smallest phase margin of 17
    degrees for the plant of table 1 (designed by :func:`bdt_study.design.pid_design.design_pid`).
    """

    proportional: float = quantity(
        3080.0, "V/m", "gain K_p", minimum=-1e9, maximum=1e9, reconfigurable=True
    )
    integral: float = quantity(
        30800.0, "V/(m s)", "gain K_i", minimum=-1e9, maximum=1e9, reconfigurable=True
    )
    derivative: float = quantity(
        -308.4, "V s/m", "gain K_d", minimum=-1e9, maximum=1e9, reconfigurable=True
    )
    filter_time: float = quantity(
        0.074,
        "s",
        "time constant T_f of the derivative's filter",
        minimum=1e-6,
        maximum=1e3,
        reconfigurable=True,
    )

    def __post_init__(self) -> None:
        validate(self)


class PidState(NamedTuple):
    """Integral of the error [m s] and the error behind the derivative's low-pass filter [m]."""

    integral: float
    filtered: float


class DiscretePid(NamedTuple):
    """Coefficients of the discrete PID for one control period.

    Attributes
    ----------
    proportional : float
        K_p [V/m].
    integral : float
        K_i [V/(m s)].
    derivative : float
        K_d / T_f [V/m].
    period : float
        Control period [s].
    decay : float
        exp(-period / T_f).
    """

    proportional: float
    integral: float
    derivative: float
    period: float
    decay: float


INITIAL_PID = PidState(0.0, 0.0)


def discretize_pid(gains: PidGains, period: float) -> DiscretePid:
    """Return the discrete equivalent of eq. 4 for a control `period` [s].

    Each error stands for the period that ends with it, and for that signal the result is exact.
    A zero error therefore leaves the integral alone at once, as eq. 8 demands in the dead zone;
    the trapezoid rule would still add half of the last error.
    """
    return DiscretePid(
        gains.proportional,
        gains.integral,
        gains.derivative / gains.filter_time,
        period,
        decay(period, gains.filter_time),
    )


def decay(period: float, time_constant: float) -> float:
    """Return exp(-period / time_constant), the same on every computer; both in seconds."""
    return float(_DECIMAL.exp(Decimal(-period / time_constant)))


def pid_step(state: PidState, error: float, step: DiscretePid) -> tuple[PidState, float]:
    """Advance the PID by one control period (eqs 4 and 5).

    Parameters
    ----------
    state : PidState
        State before.
    error : float
        Tracking error e = r - q3 [m], or e_dz of eq. 8.
    step : DiscretePid
        From :func:`discretize_pid`.

    Returns
    -------
    state : PidState
        State after.
    voltage : float
        C_PID(s) e [V].
    """
    integral = state.integral + step.period * error
    filtered = step.decay * state.filtered + (1.0 - step.decay) * error
    if abs(filtered) < SMALLEST_SIGNAL:
        filtered = 0.0
    voltage = (
        step.proportional * error + step.integral * integral + step.derivative * (error - filtered)
    )
    return PidState(integral, filtered), voltage
