"""Clocks of a recording: stamps, receive times, and one as the other."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_bags.bag_error import BagError
from bdt_bags.reading.bag_reader import RawBag
from bdt_msgs_py.topics import Topic

FloatArray = NDArray[np.float64]

LARGEST_TIME = 2.0**31
"""A stamp holds times below this [s]."""

OTHER_CLOCK = 1e7
"""A stamp this far [s] from the telemetry was not taken from the same clock."""


class MessageTimes(NamedTuple):
    """When the messages of a topic were stamped and received, in the order of the bag.

    Attributes
    ----------
    stamps : ndarray, shape (k,)
        Stamps, or times of the newest sample in the message [s], on the clock of the telemetry.
    received : ndarray, shape (k,)
        Receive times [s] since the first message of the bag that was read.
    """

    stamps: FloatArray
    received: FloatArray


NO_MESSAGES = MessageTimes(np.empty(0), np.empty(0))


def first_reception(bag: RawBag) -> int:
    """Return the earliest receive time [ns]."""
    return min(min(raw.received) for raw in bag.topics.values())


def message_times(bag: RawBag, topic: Topic, origin: float, begin: int) -> MessageTimes:
    """Return the times of a topic without decoding its messages: there are 60 000 a run.

    Parameters
    ----------
    bag : RawBag
        The bag.
    topic : Topic
        A topic whose messages begin with a ``std_msgs/Header``.
    origin : float
        Time [s] that is subtracted from the stamps.
    begin : int
        Receive time [ns] that is subtracted from the receive times.

    Raises
    ------
    BagError
        If a message is too short for a header.
    """
    raw = bag.topics.get(topic)
    if raw is None:
        return NO_MESSAGES
    if min(map(len, raw.data)) < 12:
        raise BagError(f"bag {bag.path}: a message of {raw.name} is damaged: it has no header")
    # CDR: four bytes of encapsulation, the second one tells the byte order; then the stamp.
    order = np.frombuffer(b"".join([data[1:2] for data in raw.data]), np.uint8) & 1
    joined = b"".join([data[4:12] for data in raw.data])
    little = np.frombuffer(joined, np.dtype([("sec", "<i4"), ("nanosec", "<u4")]))
    big = np.frombuffer(joined, np.dtype([("sec", ">i4"), ("nanosec", ">u4")]))
    seconds = np.where(order, little["sec"], big["sec"]).astype(np.float64)
    stamps = seconds - origin + np.where(order, little["nanosec"], big["nanosec"]) / 1e9
    return MessageTimes(stamps, since(raw.received, begin))


def batch_times(bag: RawBag, topic: Topic, origin: float, begin: int) -> MessageTimes:
    """Return the times of messages that hold rows.

    Parameters
    ----------
    bag : RawBag
        The bag.
    topic : Topic
        A topic whose batches have been read.
    origin, begin
        See :func:`message_times`.
    """
    raw = bag.topics.get(topic)
    if raw is None:
        return NO_MESSAGES
    ends = np.array([batch[-1, 0] for batch in raw.batches])
    return MessageTimes(ends - origin, since(raw.received, begin))


def since(received: Sequence[int], begin: int) -> FloatArray:
    """Return receive times [ns] as seconds since `begin` [ns], exactly to the nanosecond."""
    return np.array([time - begin for time in received], dtype=np.float64) / 1e9


def on_telemetry_clock(
    stamps: Sequence[int],
    received: Sequence[int],
    telemetry: FloatArray,
    receive_clock: MessageTimes,
    origin: float,
    begin: int,
) -> FloatArray:
    """Return stamps as times of the telemetry.

    A stamp that was left at zero, or that comes from another clock (a controller without
    simulated time), is replaced by the time of the data that was received with it.

    Parameters
    ----------
    stamps, received : sequence of int, length k
        Stamps and receive times [ns] of the same messages.
    telemetry : ndarray, shape (n, 3)
        Rows of (t [s], u [V], q3 [m]), t less `origin`.
    receive_clock : MessageTimes
        Which time of the data was received when.
    origin, begin
        See :func:`message_times`.

    Returns
    -------
    ndarray, shape (k,)
        Times [s], less `origin`.
    """
    raw = np.array(stamps, dtype=np.int64)
    times = (raw - np.int64(origin) * 1_000_000_000) / 1e9
    foreign = np.abs(times - telemetry[0, 0]) > OTHER_CLOCK
    foreign |= (raw == 0) & (np.arange(raw.size) > 0)
    if foreign.any() and len(receive_clock.stamps):
        order = np.argsort(receive_clock.received, kind="stable")
        arrivals, clock = since(received, begin), receive_clock.received[order]
        mapped = np.interp(arrivals, clock, receive_clock.stamps[order])
        times = np.where(foreign, mapped, times)
    return times
