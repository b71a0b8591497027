"""Messages of the public interface as numbers and numpy arrays.

The readers accept rclpy's messages and those of rosbags alike, so a bag needs no ROS.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.rejection import MessageRejectedError, Reason
from bdt_msgs_py.topics import MOTOR_JOINT

NANOSECONDS_PER_SECOND = 1_000_000_000
NEVER = (2**31 - 1) * NANOSECONDS_PER_SECOND
"""Latest whole second that a stamp can hold [ns]."""
MOST_NAMES = 3
LONGEST_NAME = 40
"""What a rejection tells of the names of a message."""


def nanoseconds_from_stamp(stamp: Any) -> int:
    """Return the time [ns] of a ``builtin_interfaces/Time``; integers compare without rounding."""
    return int(stamp.sec) * NANOSECONDS_PER_SECOND + int(stamp.nanosec)


def nanoseconds_from_seconds(time: float) -> int:
    """Return a time [s] of a telemetry row as the nearest nanosecond."""
    return round(time * NANOSECONDS_PER_SECOND)


def read_position(message: Any, joint: str) -> tuple[int, float]:
    """Return ``(stamp [ns], position [m or rad])`` of `joint` in a JointState.

    The message may carry other joints as well, as those of a robot's own drivers do.

    Raises
    ------
    MessageRejectedError
        If the message does not carry that joint once, with a position for each joint.
    """
    index = _index_of(message, joint, "position")
    return nanoseconds_from_stamp(message.header.stamp), float(message.position[index])


def read_voltage(message: Any, joint: str = MOTOR_JOINT) -> tuple[int, float]:
    """Return ``(stamp [ns], voltage [V])`` of `joint` in a JointState: the motor's of a command.

    Raises
    ------
    MessageRejectedError
        If the message does not carry that joint once, with an effort for each joint.
    """
    index = _index_of(message, joint, "effort")
    return nanoseconds_from_stamp(message.header.stamp), float(message.effort[index])


def read_samples(message: Any, columns: Sequence[str]) -> NDArray[np.float64]:
    """Return the rows of a Float64MultiArray written by :func:`bdt_msgs_py.writing.sample_message`.

    Parameters
    ----------
    message : Float64MultiArray
        Telemetry or truth.
    columns : sequence of str
        The labels that the message must have.

    Returns
    -------
    ndarray, shape (n, len(columns))
        A view of the message's data where possible; do not write to it.

    Raises
    ------
    MessageRejectedError
        If labels, sizes and data do not agree.
    """
    dimensions = message.layout.dim
    labels = dimensions[1].label if len(dimensions) == 2 else ""
    if labels != ",".join(columns):
        raise MessageRejectedError(
            Reason.LAYOUT, f"sample columns {labels!r}: must be {','.join(columns)!r}"
        )
    data = np.asarray(message.data, dtype=np.float64)
    width = len(columns)
    offset = int(message.layout.data_offset)
    count = int(dimensions[0].size)
    if int(dimensions[1].size) != width or data.size - offset != count * width:
        raise MessageRejectedError(
            Reason.LAYOUT,
            f"{data.size} values with offset {offset}: must be {count} rows of {width} columns",
        )
    return data[offset:].reshape(count, width)


def _index_of(message: Any, joint: str, quantity: str) -> int:
    names, values = message.name, getattr(message, quantity)
    if len(values) == len(names) == 1 and names[0] == joint:
        return 0
    if list(names).count(joint) != 1 or len(values) != len(names):
        raise MessageRejectedError(
            Reason.LAYOUT,
            f"JointState with names {_shortened(names)} and {len(values)} {quantity} values: "
            f"must have the joint {joint} once and one {quantity} for each joint",
        )
    return list(names).index(joint)


def _shortened(names: Sequence[str]) -> list[str]:
    few = [name[:LONGEST_NAME] for name in names[:MOST_NAMES]]
    return [*few, "..."] if len(names) > MOST_NAMES else few
