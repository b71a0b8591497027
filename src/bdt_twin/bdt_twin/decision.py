"""What the twin has decided: dead zone, gains, reason and expectation."""

import math
from typing import NamedTuple

from bdt_controller.notch import NotchFilter
from bdt_controller.pid import PidGains


class ControllerGains(NamedTuple):
    """What the controller's linear part is set to."""

    pid: PidGains
    notch: NotchFilter

    def by_name(self) -> tuple[tuple[str, float], ...]:
        """Return them by the names of the controller's parameters."""
        parts = (("pid", self.pid), ("notch", self.notch))
        return tuple(
            (f"{prefix}.{name}", float(value))
            for prefix, part in parts
            for name, value in vars(part).items()
        )


class Decision(NamedTuple):
    """What the twin has decided, why, and what it expects.

    Attributes
    ----------
    tolerance : float or None
        Dead-zone tolerance epsilon_dz [m]; None for that of the rule.
    gains : ControllerGains or None
        Gains to be set with it; None to leave them as they are.
    reason : str
        Why, in one line.
    ratio : float
        Tolerance over that of eq. 9; NaN for that of the rule.
    bias : float
        Largest bias expected, as a share of the height of the simulated steps; NaN for none.
    settling : float
        Median settling time expected [s]; NaN for none.
    taken_back : int
        Decisions that were taken back so far.
    distrust : str
        Why the last of them was, as long as simulation is not trusted; empty otherwise.
    """

    tolerance: float | None
    gains: ControllerGains | None
    reason: str
    ratio: float = math.nan
    bias: float = math.nan
    settling: float = math.nan
    taken_back: int = 0
    distrust: str = ""


def taken_back_because(before: Decision | None, decision: Decision | None) -> str:
    """Return why a decision takes another one back; empty if it does not."""
    so_far = 0 if before is None else before.taken_back
    return decision.reason if decision is not None and decision.taken_back > so_far else ""


def decision_values(decision: Decision | None) -> dict[str, float | int | str | None]:
    """Return a decision as the diagnostics tell it, by name."""
    if decision is None:
        return {"decision": "equation_9"}
    return {
        "decision": "simulate",
        "decision_reason": decision.reason,
        "decision_ratio": decision.ratio,
        "expected_bias_percent": 100.0 * decision.bias,
        "expected_settling_s": decision.settling,
        "decisions_taken_back": decision.taken_back,
    }
