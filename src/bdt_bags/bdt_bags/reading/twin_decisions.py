"""What a twin has decided by simulation and what it expected, as its diagnostics tell."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_bags.reading.bag_reader import RawBag, decode
from bdt_msgs_py.reading import nanoseconds_from_stamp
from bdt_msgs_py.topics import DIAGNOSTICS, TWIN_NODE

SIMULATED = "simulate"
"""Value of ``decision`` of a twin that decides by simulation."""


@dataclass(frozen=True)
class TwinDecision:
    """A decision and what was expected of it.

    Attributes
    ----------
    time : float
        When it was published [s].
    reason : str
        Why it was made.
    ratio : float or None
        Dead zone over that of eq. 9; None for that of the rule.
    expected_bias_percent : float or None
        Largest bias expected [% of the height of a step]; None for no expectation.
    expected_settling : float or None
        Median settling time expected [s]; None for no expectation.
    taken_back : int
        Decisions that were taken back until then.
    """

    time: float
    reason: str
    ratio: float | None
    expected_bias_percent: float | None
    expected_settling: float | None
    taken_back: int


def recorded_decisions(
    bag: RawBag,
    namespace: str,
    times: Callable[[Sequence[int], Sequence[int]], NDArray[np.float64]],
) -> tuple[TwinDecision, ...]:
    """Return the decisions of the twin of a loop, without those that say nothing new.

    Parameters
    ----------
    bag : RawBag
        The bag.
    namespace : str
        Namespace of the loop.
    times : callable
        Brings stamps and receive times [ns] to the clock of the telemetry [s].
    """
    raw = bag.topics.get(DIAGNOSTICS)
    if raw is None:
        return ()
    name = f"{namespace}/{TWIN_NODE}"
    stamps, received, told = [], [], []
    for message, arrival in zip(decode(bag.path, raw), raw.received, strict=True):
        for status in message.status:
            values = {item.key: item.value for item in status.values}
            if status.name == name and values.get("decision") == SIMULATED:
                stamps.append(nanoseconds_from_stamp(message.header.stamp))
                received.append(arrival)
                told.append(values)
    decisions: list[TwinDecision] = []
    for time, values in zip(times(stamps, received).tolist(), told, strict=True):
        decision = _decision(time, values)
        if not decisions or vars(decision) | {"time": 0.0} != vars(decisions[-1]) | {"time": 0.0}:
            decisions.append(decision)
    return tuple(decisions)


def _decision(time: float, values: Mapping[str, Any]) -> TwinDecision:
    taken_back = _number(values.get("decisions_taken_back"))
    return TwinDecision(
        time,
        str(values.get("decision_reason", "")),
        _number(values.get("decision_ratio")),
        _number(values.get("expected_bias_percent")),
        _number(values.get("expected_settling_s")),
        int(taken_back or 0),
    )


def _number(text: Any) -> float | None:
    try:
        value = float(text)
    except (TypeError, ValueError):
        return None
    return value if math.isfinite(value) and value >= 0.0 else None
