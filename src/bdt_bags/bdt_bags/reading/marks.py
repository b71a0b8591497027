"""Moments that somebody has marked while a loop ran, as a bag tells them."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from bdt_bags.reading.bag_reader import RawBag, decode
from bdt_msgs_py.message_checks import check_stamp
from bdt_msgs_py.rejection import MessageRejectedError
from bdt_msgs_py.topics import MARK


def recorded_marks(
    bag: RawBag, times: Callable[[Sequence[int], Sequence[int]], NDArray[np.float64]]
) -> tuple[float, ...]:
    """Return the marks of a run in the order of time [s]; a stamp that is no time marks nothing.

    Parameters
    ----------
    bag : RawBag
        The bag.
    times : callable
        Brings stamps and receive times [ns] to the clock of the telemetry [s].
    """
    raw = bag.topics.get(MARK)
    if raw is None:
        return ()
    stamps, received = [], []
    for message, arrival in zip(decode(bag.path, raw), raw.received, strict=True):
        try:
            stamps.append(check_stamp(message.stamp))
        except MessageRejectedError:
            continue
        received.append(arrival)
    return tuple(sorted(times(stamps, received).tolist()))
