"""Clocks of a recording: stamps, receive times, and one as the other."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bdt_bringup.bags.bag_reader import BagError, RawBag
from bdt_msgs_py.topics import MEASUREMENT, TELEMETRY, Topic

FloatArray = NDArray[np.float64]

LARGEST_TIME = 2.0**31
"""A stamp holds times below this [s]."""

_OTHER_CLOCK = 1e7
"""A stamp this far [s] from the telemetry was not taken from the same clock."""


def header_stamps(bag: RawBag, topic: Topic, origin: float) -> FloatArray:
    """Return the header stamps of a topic without decoding its messages: there are 60 000 a run.

    Parameters
    ----------
    bag : RawBag
        The bag.
    topic : Topic
        A topic whose messages begin with a ``std_msgs/Header``.
    origin : float
        Time [s] that is subtracted.

    Returns
    -------
    ndarray, shape (k,)
        Stamps [s] in the order of the bag; empty without the topic.

    Raises
    ------
    BagError
        If a message is too short for a header.
    """
    raw = bag.topics.get(topic)
    if raw is None or not raw.data:
        return np.empty(0)
    if min(map(len, raw.data)) < 12:
        raise BagError(f"bag {bag.path}: a message of {raw.name} is damaged: it has no header")
    # CDR: four bytes of encapsulation, the second one tells the byte order; then the stamp.
    order = np.frombuffer(b"".join([data[1:2] for data in raw.data]), np.uint8) & 1
    joined = b"".join([data[4:12] for data in raw.data])
    little = np.frombuffer(joined, np.dtype([("sec", "<i4"), ("nanosec", "<u4")]))
    big = np.frombuffer(joined, np.dtype([("sec", ">i4"), ("nanosec", ">u4")]))
    seconds = np.where(order, little["sec"], big["sec"]).astype(np.float64)
    return seconds - origin + np.where(order, little["nanosec"], big["nanosec"]) / 1e9


def reception_clock(
    bag: RawBag, batches: list[FloatArray], measurement_stamps: FloatArray, origin: float
) -> FloatArray:
    """Return which time of the data was received when.

    Parameters
    ----------
    bag : RawBag
        The bag.
    batches : list of ndarray, shape (n, 3)
        Rows of each telemetry message; they serve when there are no measurements.
    measurement_stamps : ndarray, shape (k,)
        Stamps of the measurements [s], less `origin`.
    origin : float
        Time [s] that is subtracted from the data.

    Returns
    -------
    ndarray, shape (j, 2)
        Rows of (receive time [s], time of the data [s]) in the order of reception.
    """
    if len(measurement_stamps):
        received, times = bag.topics[MEASUREMENT].received, measurement_stamps
    else:
        pairs = zip(bag.topics[TELEMETRY].received, batches, strict=True)
        ends = [(r, batch[-1, 0]) for r, batch in pairs if len(batch)]
        ends = [(r, end) for r, end in ends if abs(end) < LARGEST_TIME]
        received, times = [r for r, _ in ends], np.array([end for _, end in ends]) - origin
    clock = np.stack([np.array(received, dtype=np.int64) / 1e9, times], axis=1)
    return clock[np.argsort(clock[:, 0], kind="stable")]


def on_telemetry_clock(
    stamps: Sequence[int],
    received: Sequence[int],
    telemetry: FloatArray,
    receive_clock: FloatArray,
    origin: float,
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
    receive_clock : ndarray, shape (j, 2)
        From :func:`reception_clock`.
    origin : float
        Time [s] that is subtracted.

    Returns
    -------
    ndarray, shape (k,)
        Times [s], less `origin`.
    """
    raw = np.array(stamps, dtype=np.int64)
    times = (raw - np.int64(origin) * 1_000_000_000) / 1e9
    foreign = np.abs(times - telemetry[0, 0]) > _OTHER_CLOCK
    foreign |= (raw == 0) & (np.arange(raw.size) > 0)
    if foreign.any() and len(receive_clock):
        arrivals = np.array(received, dtype=np.int64) / 1e9
        mapped = np.interp(arrivals, receive_clock[:, 0], receive_clock[:, 1])
        times = np.where(foreign, mapped, times)
    return times
