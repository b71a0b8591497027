"""Joints in a bag: references, estimates, and what was asked for because of them."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_bags.bag_error import BagError
from bdt_bags.reading.bag_reader import RawBag, decode
from bdt_bags.reading.sample_rows import LARGEST_VALUE
from bdt_msgs_py.reading import read_position, read_voltage
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    DEAD_ZONE_JOINT,
    GAP_AGE_JOINT,
    GAP_JOINT,
    VOLTAGE_OFFSET_JOINT,
    Topic,
)

FloatArray = NDArray[np.float64]
Clock = Callable[[Sequence[int], Sequence[int]], FloatArray]
"""Turns stamps and receive times [ns] into times on the clock of the telemetry [s]."""


def joint_positions(
    bag: RawBag, topic: Topic, joint: str, clock: Clock, *, optional: bool = False
) -> FloatArray:
    """Return rows of (time [s], position) of a joint in the order of time.

    Parameters
    ----------
    bag : RawBag
        The bag.
    topic : Topic
        Where the joint stands.
    joint : str
        Its name.
    clock : callable
        See :data:`Clock`.
    optional : bool
        Whether messages without the joint are left out.

    Returns
    -------
    ndarray, shape (k, 2)
        Rows of (time [s], position [m or rad]); those that are not finite are left out.

    Raises
    ------
    BagError
        If a message contradicts itself, or lacks a joint that is not optional.
    """

    def read(message: Any) -> tuple[int, float] | None:
        if optional and joint not in message.name:
            return None
        return read_position(message, joint)

    return _in_order(_rows(bag, topic, read, clock, 2))


def dead_zone_requests(bag: RawBag, clock: Clock) -> FloatArray:
    """Return the dead zones that the twin asked for, as it tells them with its estimates.

    Parameters
    ----------
    bag : RawBag
        The bag.
    clock : callable
        See :data:`Clock`.

    Returns
    -------
    ndarray, shape (k, 4)
        See :class:`bdt_bags.run_signals.RunSignals`.

    Raises
    ------
    BagError
        If a message contradicts itself.
    """
    times, ages, tolerances, gaps = _rows(bag, BACKLASH_ESTIMATE, _read_request, clock, 4).T
    return _in_order(np.stack([times + ages, tolerances, times, gaps], axis=1))


def voltage_offset_requests(bag: RawBag, clock: Clock) -> FloatArray:
    """Return the voltage offsets that the twin asked for, as it tells them with its estimates.

    Parameters
    ----------
    bag : RawBag
        The bag.
    clock : callable
        See :data:`Clock`.

    Returns
    -------
    ndarray, shape (k, 2)
        See :class:`bdt_bags.run_signals.RunSignals`.

    Raises
    ------
    BagError
        If a message contradicts itself.
    """

    def read(message: Any) -> tuple[int, float, float] | None:
        if VOLTAGE_OFFSET_JOINT not in message.name:
            return None
        stamp, voltage = read_voltage(message, VOLTAGE_OFFSET_JOINT)
        return stamp, _age(message), voltage

    return _by_newest_sample(bag, read, clock)


def held_gaps(bag: RawBag, clock: Clock) -> FloatArray:
    """Return which gap the twin held from when on.

    Parameters
    ----------
    bag : RawBag
        The bag.
    clock : callable
        See :data:`Clock`.

    Returns
    -------
    ndarray, shape (k, 2)
        See :class:`bdt_bags.run_signals.RunSignals`.

    Raises
    ------
    BagError
        If a message contradicts itself.
    """

    def read(message: Any) -> tuple[int, float, float]:
        stamp, gap = read_position(message, GAP_JOINT)
        return stamp, _age(message), gap

    return _by_newest_sample(bag, read, clock)


def _by_newest_sample(
    bag: RawBag, read: Callable[[Any], tuple[int, float, float] | None], clock: Clock
) -> FloatArray:
    """Return rows of (time of the newest sample behind an estimate [s], what was read with it)."""
    times, ages, values = _rows(bag, BACKLASH_ESTIMATE, read, clock, 3).T
    return _in_order(np.stack([times + ages, values], axis=1))


def _read_request(message: Any) -> tuple[int, float, float, float] | None:
    """Return stamp [ns], age [s], tolerance [m] and gap [rad]; None if nothing was asked for."""
    if DEAD_ZONE_JOINT not in message.name:
        return None
    stamp, gap = read_position(message, GAP_JOINT)
    return stamp, _age(message), read_position(message, DEAD_ZONE_JOINT)[1], gap


def _age(message: Any) -> float:
    """Return the age [s]: whoever does not tell it states the gap for the newest sample."""
    return read_position(message, GAP_AGE_JOINT)[1] if GAP_AGE_JOINT in message.name else 0.0


def _rows(
    bag: RawBag,
    topic: Topic,
    read: Callable[[Any], tuple[int, *tuple[float, ...]] | None],
    clock: Clock,
    columns: int,
) -> FloatArray:
    """Return rows of (time [s], numbers) in the order of the bag; only finite ones.

    `read` turns a message into (stamp [ns], numbers), or into None to leave it out; the result
    has so many `columns`, also without a row.
    """
    raw = bag.topics.get(topic)
    if raw is None:
        return np.empty((0, columns))
    stamps, received, rows = [], [], []
    for number, message in enumerate(decode(bag.path, raw)):
        try:
            row = read(message)
        except ValueError as error:
            raise BagError(f"bag {bag.path}: message {number} of {raw.name}: {error}") from None
        if row is not None:
            stamps.append(row[0])
            received.append(raw.received[number])
            rows.append(row[1:])
    if not rows:
        return np.empty((0, columns))
    values = np.array(rows)
    times = clock(stamps, received)
    kept = (np.abs(values) < LARGEST_VALUE).all(axis=1)  # the nodes ignore what is not finite
    found: FloatArray = np.column_stack([times, values])[kept]
    return found


def _in_order(rows: FloatArray) -> FloatArray:
    """Return rows in the order of their first column, the time."""
    ordered: FloatArray = rows[np.argsort(rows[:, 0], kind="stable")]
    return ordered
