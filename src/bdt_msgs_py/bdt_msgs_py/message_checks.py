"""What comes from outside, checked field by field, as numbers that can be worked with.

Every node takes its messages through these functions. They raise :class:`MessageRejectedError`
and nothing else, whatever the fields hold. Whether a valid message fits the time and the state of
the loop is for its receiver to say (:mod:`bdt_msgs_py.time_sequence`).
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.command_errors import printable
from bdt_msgs_py.reading import (
    NANOSECONDS_PER_SECOND,
    nanoseconds_from_stamp,
    read_position,
    read_samples,
    read_voltage,
)
from bdt_msgs_py.rejection import MessageRejectedError, Reason
from bdt_msgs_py.topics import DEAD_ZONE_PARAMETER, GAP_JOINT, PLATFORM_JOINT, TELEMETRY_COLUMNS

LARGEST_POSITION = 1e3
"""Position of a platform of either sign [m]."""
LARGEST_VOLTAGE = 1e6
"""Voltage in telemetry of either sign [V]."""
LARGEST_GAP = 100.0
"""Backlash gap of either sign [rad]."""
LARGEST_TIME = float(2**31)
"""Time of a sample [s]; no stamp can hold a later one."""
LONGEST_NAME = 100
"""Characters of a name that are kept."""

FloatArray = NDArray[np.float64]


class VoltageCommand(NamedTuple):
    """A command as the plant takes it.

    Attributes
    ----------
    stamp : int
        Stamp of the measurement that it answers [ns].
    voltage : float
        Motor voltage [V], finite.
    source : str
        Who sent it; empty if nobody says so.
    """

    stamp: int
    voltage: float
    source: str


class NodeProgress(NamedTuple):
    """Word of a node that keeps step with a lockstep plant: see ``PROGRESS``."""

    node: str
    telemetry_end: int
    earliest_action: int


def check_stamp(stamp: Any) -> int:
    """Return a ``builtin_interfaces/Time`` in nanoseconds.

    Raises
    ------
    MessageRejectedError
        If it is before zero, or has a second or more of nanoseconds.
    """
    if stamp.sec < 0 or not 0 <= stamp.nanosec < NANOSECONDS_PER_SECOND:
        raise MessageRejectedError(
            Reason.STAMP,
            f"stamp {stamp.sec} s and {stamp.nanosec} ns: must be 0 s or later, below 1e9 ns",
        )
    return nanoseconds_from_stamp(stamp)


def check_position(message: Any) -> tuple[int, float]:
    """Return ``(stamp [ns], position [m])`` of a measurement or a reference.

    Raises
    ------
    MessageRejectedError
        For wrong names or lengths, a stamp that is no time, or a position that is none.
    """
    _, position = read_position(message, PLATFORM_JOINT)
    stamp = check_stamp(message.header.stamp)
    return stamp, _number("position", position, LARGEST_POSITION, "m")


def check_command(message: Any) -> VoltageCommand:
    """Return a command; how much voltage is too much is for the hardware's limits to say.

    Raises
    ------
    MessageRejectedError
        For wrong names or lengths, a stamp that is no time, or a voltage that is not finite.
    """
    _, voltage = read_voltage(message)
    stamp = check_stamp(message.header.stamp)
    source = _name(message.header.frame_id)
    return VoltageCommand(stamp, _number("motor voltage", voltage, math.inf, "V"), source)


def check_telemetry_times(message: Any) -> FloatArray:
    """Return telemetry rows (t [s], u [V], q3 [m]) whose times are times.

    Raises
    ------
    MessageRejectedError
        For a wrong layout, no rows, or times that are no times or do not increase.
    """
    rows = read_samples(message, TELEMETRY_COLUMNS)
    if not len(rows):
        raise MessageRejectedError(Reason.LAYOUT, "0 rows: must be one at least")
    times = rows[:, 0]
    for position in (0, -1):
        _number("time", float(times[position]), LARGEST_TIME, "s", lowest=0.0)
    # False for what is not a number, too.
    if not np.all(times[1:] > times[:-1]):
        row = int(np.flatnonzero(~(times[1:] > times[:-1]))[0]) + 1
        raise MessageRejectedError(
            Reason.TIME, f"time {times[row]} s in row {row}: must be after that of the row before"
        )
    return rows


def check_telemetry_values(rows: FloatArray) -> None:
    """Check voltages and positions of telemetry.

    Raises
    ------
    MessageRejectedError
        For a value that is not finite, or that no machine has.
    """
    for column, name, largest, unit in (
        (1, "motor voltage", LARGEST_VOLTAGE, "V"),
        (2, "position", LARGEST_POSITION, "m"),
    ):
        values = rows[:, column]
        within = np.abs(values) <= largest
        if not within.all():
            row = int(np.flatnonzero(~within)[0])
            _number(f"row {row}: {name}", float(values[row]), largest, unit)


def check_progress(message: Any) -> NodeProgress:
    """Return the word of a node that keeps step.

    Raises
    ------
    MessageRejectedError
        For a stamp that is no time.
    """
    return NodeProgress(
        _name(message.source),
        check_stamp(message.header.stamp),
        check_stamp(message.time_ref),
    )


def check_clock(message: Any) -> int:
    """Return simulated time [ns].

    Raises
    ------
    MessageRejectedError
        For a time before zero, or one with a second or more of nanoseconds.
    """
    return check_stamp(message.clock)


def check_estimate(message: Any) -> tuple[int, float]:
    """Return ``(stamp [ns], gap [rad])`` of a backlash estimate.

    Raises
    ------
    MessageRejectedError
        For wrong names or lengths, a stamp that is no time, or a gap that is none.
    """
    _, gap = read_position(message, GAP_JOINT)
    stamp = check_stamp(message.header.stamp)
    return stamp, _number("gap", gap, LARGEST_GAP, "rad")


def check_dead_zone(value: Any) -> float:
    """Return a dead-zone tolerance [m] from the ``ParameterValue`` of a parameter event.

    Raises
    ------
    MessageRejectedError
        If it is no number, or one that no dead zone has.
    """
    double = 3  # rcl_interfaces/ParameterType.PARAMETER_DOUBLE, which a bag's reader has not
    if value.type != double:
        raise MessageRejectedError(
            Reason.LAYOUT, f"{DEAD_ZONE_PARAMETER} of parameter type {value.type}: must be a double"
        )
    return _number(
        DEAD_ZONE_PARAMETER, float(value.double_value), LARGEST_POSITION, "m", lowest=0.0
    )


def _name(text: str) -> str:
    return (text if text.isprintable() else printable(text))[:LONGEST_NAME]


def _number(
    name: str, value: float, largest: float, unit: str, *, lowest: float | None = None
) -> float:
    if not math.isfinite(value):
        raise MessageRejectedError(Reason.NOT_FINITE, f"{name} {value} {unit}: must be finite")
    smallest = -largest if lowest is None else lowest
    if not smallest <= value <= largest:
        raise MessageRejectedError(
            Reason.RANGE, f"{name} {value:g} {unit}: must be {smallest:g} to {largest:g} {unit}"
        )
    return value
