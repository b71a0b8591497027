"""Rows of samples: from messages with many rows, or from measurements and commands."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_bags.reading.bag_reader import RawBag, RawTopic
from bdt_bags.reading.joint_values import joint_values
from bdt_msgs_py.reading import read_position, read_voltage
from bdt_msgs_py.topics import COMMAND, MEASUREMENT, PLATFORM_JOINT

FloatArray = NDArray[np.float64]

LARGEST_VALUE = 1e100
"""What is beyond this has left physics, and soon floating point; it counts as not finite."""


class SampleRows(NamedTuple):
    """Samples in the order of time.

    Attributes
    ----------
    rows : ndarray, shape (n, c)
        Rows whose values are all known, times strictly increasing.
    times : ndarray, shape (m,)
        Times of all samples [s], also of those with a value that is missing.
    """

    rows: FloatArray
    times: FloatArray


def ordered_rows(raw: RawTopic) -> SampleRows:
    """Return the samples of a topic in the order of time.

    A batch that was recorded twice counts once, one that came late stands where it belongs. A
    value that is not finite is a missing one: its row is left out.

    Parameters
    ----------
    raw : RawTopic
        Messages of one run, whose batches of rows begin with the time [s].
    """
    return _ordered(np.concatenate(raw.batches))


def _ordered(rows: FloatArray) -> SampleRows:
    if (np.diff(rows[:, 0]) <= 0).any():
        rows = rows[np.unique(rows[:, 0], return_index=True)[1]]
    known = (np.abs(rows) < LARGEST_VALUE).all(axis=1)
    return SampleRows(rows if known.all() else rows[known], rows[:, 0].copy())


def rows_of_messages(bag: RawBag) -> SampleRows:
    """Return (t [s], u [V], q3 [m]) at the control rate, for a bag without telemetry.

    Each measurement stands beside the command that answers it; where there is none the voltage
    is NaN.

    Parameters
    ----------
    bag : RawBag
        One run, with measurements.

    Raises
    ------
    BagError
        If a message is damaged.
    """
    stamps, positions, _ = joint_values(
        bag.path,
        bag.topics[MEASUREMENT],
        lambda message: read_position(message, PLATFORM_JOINT),
        "position",
    )
    voltages = np.full(stamps.size, np.nan)
    if COMMAND in bag.topics:
        answered, values, _ = joint_values(bag.path, bag.topics[COMMAND], read_voltage, "effort")
        order = np.argsort(answered, kind="stable")
        place = np.searchsorted(answered, stamps, sorter=order)
        place = order[np.minimum(place, answered.size - 1)]
        voltages = np.where(answered[place] == stamps, values[place], np.nan)
    seconds, rest = np.divmod(stamps, 1_000_000_000)
    table = np.stack([seconds + rest / 1e9, voltages, positions], axis=1)
    found = _ordered(table[:, [0, 2]])
    _, first = np.unique(table[:, 0], return_index=True)
    voltages = table[first, 1][np.searchsorted(table[first, 0], found.rows[:, 0])]
    voltages = np.where(np.abs(voltages) < LARGEST_VALUE, voltages, np.nan)
    rows = np.stack([found.rows[:, 0], voltages, found.rows[:, 1]], axis=1)
    return SampleRows(rows, found.times)
