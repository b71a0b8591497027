"""Numbers and numpy arrays as messages of the public interface."""

from array import array
from collections.abc import Sequence

import numpy as np
from builtin_interfaces.msg import Time
from numpy.typing import NDArray
from sensor_msgs.msg import JointState, TimeReference
from std_msgs.msg import Float64MultiArray, Header, MultiArrayDimension, MultiArrayLayout

from bdt_msgs_py.reading import NANOSECONDS_PER_SECOND, NEVER
from bdt_msgs_py.topics import (
    DEAD_ZONE_JOINT,
    GAP_AGE_JOINT,
    GAP_JOINT,
    GAP_UNCERTAINTY_JOINT,
    MOTOR_JOINT,
    PLATFORM_JOINT,
    VOLTAGE_OFFSET_JOINT,
)


def stamp_from_nanoseconds(nanoseconds: int) -> Time:
    """Return the message ``builtin_interfaces/Time`` for a time [ns]."""
    seconds, rest = divmod(nanoseconds, NANOSECONDS_PER_SECOND)
    return Time(sec=seconds, nanosec=rest)


def platform_position(stamp: int, position: float) -> JointState:
    """Return a measurement or a reference.

    Parameters
    ----------
    stamp : int
        Sample time, or time from which the reference holds [ns].
    position : float
        Position of platform 3 [m].
    """
    return _joint_position(PLATFORM_JOINT, stamp, position)


def gap_estimate(
    stamp: int,
    gap: float,
    uncertainty: float,
    growth: float,
    age: float = 0.0,
    tolerance: float | None = None,
    voltage_offset: float | None = None,
) -> JointState:
    """Return an estimate of the backlash gap; what belongs to it stands in joints of its own.

    Parameters
    ----------
    stamp : int
        Time for which the gap is stated [ns].
    gap, uncertainty : float
        Gap theta_b and its standard uncertainty [rad]; NaN if nobody knows how sure it is.
    growth : float
        Growth rate of the gap [rad/s].
    age : float
        Time from the stamp to the newest sample behind the estimate [s].
    tolerance : float or None
        Dead-zone tolerance that is asked for because of the estimate [m]; None for none.
    voltage_offset : float or None
        Voltage that the controller is asked to add to its commands [V]; None for none.
    """
    joints = {GAP_JOINT: gap, GAP_UNCERTAINTY_JOINT: uncertainty, GAP_AGE_JOINT: age}
    if tolerance is not None:
        joints[DEAD_ZONE_JOINT] = tolerance
    effort: tuple[float, ...] = ()
    if voltage_offset is not None:
        effort = (*[0.0] * len(joints), voltage_offset)
        joints[VOLTAGE_OFFSET_JOINT] = 0.0
    return JointState(
        header=Header(stamp=stamp_from_nanoseconds(stamp)),
        name=list(joints),
        position=array("d", joints.values()),
        velocity=array("d", (growth, *[0.0] * (len(joints) - 1))),
        effort=array("d", effort),
    )


def motor_voltage(stamp: int, voltage: float, source: str = "") -> JointState:
    """Return a command.

    The voltage stands in the ``effort`` field: it is the effort variable of the electrical domain.

    Parameters
    ----------
    stamp : int
        Stamp of the measurement that the command answers [ns].
    voltage : float
        Motor voltage u [V].
    source : str
        Who sends it, in ``header.frame_id``: the plant obeys one source at a time.
    """
    return JointState(
        header=Header(stamp=stamp_from_nanoseconds(stamp), frame_id=source),
        name=[MOTOR_JOINT],
        effort=array("d", (voltage,)),
    )


def progress(node: str, telemetry_end: int, earliest_action: int | None) -> TimeReference:
    """Return the word of a node that keeps step with a lockstep plant.

    Parameters
    ----------
    node : str
        Name of the node.
    telemetry_end : int
        Stamp of the newest telemetry sample that the node has worked on [ns].
    earliest_action : int or None
        Simulated time before which the node will not act on the loop [ns], whatever telemetry
        is still to come; None for never.
    """
    return TimeReference(
        header=Header(stamp=stamp_from_nanoseconds(telemetry_end)),
        time_ref=stamp_from_nanoseconds(NEVER if earliest_action is None else earliest_action),
        source=node,
    )


def mark(stamp: int, source: str) -> Header:
    """Return a mark.

    Parameters
    ----------
    stamp : int
        The moment that is marked [ns].
    source : str
        Who marks it.
    """
    return Header(stamp=stamp_from_nanoseconds(stamp), frame_id=source)


def sample_message(rows: NDArray[np.float64], columns: Sequence[str]) -> Float64MultiArray:
    """Return telemetry or truth with one row a sample.

    Parameters
    ----------
    rows : ndarray, shape (n, len(columns))
        Samples, oldest first.
    columns : sequence of str
        Column labels with units, written into the layout.

    Raises
    ------
    ValueError
        If the shape does not fit the columns.
    """
    if rows.ndim != 2 or rows.shape[1] != len(columns):
        raise ValueError(f"rows of shape {rows.shape}: must be (n, {len(columns)})")
    count, width = rows.shape
    # One bulk copy: rclpy converts a list of floats element by element, 30 to 100 times slower.
    data = array("d")
    data.frombytes(np.ascontiguousarray(rows, dtype=np.float64).tobytes())
    samples = MultiArrayDimension(label="sample", size=count, stride=count * width)
    labels = MultiArrayDimension(label=",".join(columns), size=width, stride=width)
    return Float64MultiArray(layout=MultiArrayLayout(dim=[samples, labels]), data=data)


def _joint_position(joint: str, stamp: int, position: float) -> JointState:
    return JointState(
        header=Header(stamp=stamp_from_nanoseconds(stamp)),
        name=[joint],
        position=array("d", (position,)),
    )
