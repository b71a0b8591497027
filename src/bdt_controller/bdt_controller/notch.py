"""A second-order filter in series with the PID: a notch, off by default.

The paper's controller has none. Where the uncertainty of a mechanism is too much for a PID, it
takes the resonance out of the loop.
"""

from dataclasses import dataclass
from typing import NamedTuple

from bdt_msgs_py.quantities import quantity, validate

SMALLEST_VOLTAGE = 1e-30
"""A decaying filter state [V, V/s] below this is zero: subnormal floats are slow."""


@dataclass(frozen=True)
class NotchFilter:
    """N(s) = (s^2 + 2 z_0 w s + w^2) / (s^2 + 2 z_p w s + w^2), in series with eq. 4.

    Its gain is 1 at low and at high frequencies, and z_0 / z_p at w.
    """

    frequency: float = quantity(
        0.0,
        "rad/s",
        "frequency w of the filter in series with the PID; 0 for no filter",
        minimum=0.0,
        maximum=1e5,
        reconfigurable=True,
    )
    zero_damping: float = quantity(
        0.1,
        "",
        "damping z_0 of its zeros; its gain at w is z_0 / z_p",
        minimum=0.0,
        maximum=100.0,
        reconfigurable=True,
    )
    pole_damping: float = quantity(
        0.7,
        "",
        "damping z_p of its poles: the larger, the wider",
        minimum=0.01,
        maximum=100.0,
        reconfigurable=True,
    )

    def __post_init__(self) -> None:
        validate(self)


NO_NOTCH = NotchFilter()
"""The paper's controller has none."""


class NotchState(NamedTuple):
    """Voltage behind the filter's low-pass w^2 / (s^2 + 2 z_p w s + w^2) [V], and its rate [V/s].

    Both have a meaning that no coefficient changes, so that they can be kept when these change.
    """

    low_pass: float
    rate: float


class DiscreteNotch(NamedTuple):
    """Coefficients of the discrete filter for one control period.

    Attributes
    ----------
    is_on : bool
        Whether there is a filter.
    stiffness : float
        w^2 times the period [1/s].
    half_damping : float
        z_p w times the period.
    half_period : float
        Half of the period [s].
    inverse : float
        1 / determinant of the implicit step.
    depth : float
        2 (z_p - z_0) / w [s].
    """

    is_on: bool
    stiffness: float
    half_damping: float
    half_period: float
    inverse: float
    depth: float


NOTCH_AT_REST = NotchState(0.0, 0.0)


def discretize_notch(notch: NotchFilter, period: float) -> DiscreteNotch:
    """Return the discrete equivalent of the filter for a control `period` [s].

    The low-pass is advanced by the trapezoid rule, with each voltage standing for the period that
    ends with it, as in :func:`bdt_controller.pid.discretize_pid`. It is stable for any period and
    exact at rest; the frequency is low by a share of (w period)^2 / 12.
    """
    w = float(notch.frequency)
    if w == 0.0:
        return DiscreteNotch(False, 0.0, 0.0, 0.5 * period, 1.0, 0.0)
    stiffness, half_damping = w * w * period, notch.pole_damping * w * period
    half_period = 0.5 * period
    return DiscreteNotch(
        True,
        stiffness,
        half_damping,
        half_period,
        1.0 / (1.0 + half_damping + half_period * (0.5 * stiffness)),
        2.0 * (notch.pole_damping - notch.zero_damping) / w,
    )


def notch_step(state: NotchState, voltage: float, step: DiscreteNotch) -> tuple[NotchState, float]:
    """Advance the filter by one control period.

    Parameters
    ----------
    state : NotchState
        State before.
    voltage : float
        Voltage of the PID [V].
    step : DiscreteNotch
        From :func:`discretize_notch`; of a filter that is on.

    Returns
    -------
    state : NotchState
        State after.
    voltage : float
        N(s) times the voltage [V].
    """
    middle = state.low_pass + 0.5 * step.half_period * state.rate
    change = step.stiffness * (voltage - middle)
    rate = (state.rate * (1.0 - step.half_damping) + change) * step.inverse
    low_pass = state.low_pass + step.half_period * (state.rate + rate)
    if abs(rate) < SMALLEST_VOLTAGE:
        rate = 0.0
    if abs(low_pass) < SMALLEST_VOLTAGE:
        low_pass = 0.0
    return NotchState(low_pass, rate), voltage - step.depth * rate


def notch_at(voltage: float) -> NotchState:
    """Return the state in which the filter lets a constant voltage [V] pass as it is."""
    return NotchState(voltage, 0.0)
