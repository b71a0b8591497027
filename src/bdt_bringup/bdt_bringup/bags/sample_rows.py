"""Rows of samples: from messages with many rows, or from measurements and commands."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_bringup.bags.bag_error import BagError
from bdt_bringup.bags.bag_reader import RawBag, decode
from bdt_bringup.bags.joint_values import joint_values
from bdt_bringup.bags.recording_clock import LARGEST_TIME, message_times
from bdt_bringup.bags.run_selection import run_limits, select_run
from bdt_msgs_py.reading import read_position, read_samples, read_voltage
from bdt_msgs_py.topics import (
    COMMAND,
    MEASUREMENT,
    PLATFORM_JOINT,
    TELEMETRY,
    TELEMETRY_COLUMNS,
    Topic,
)

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


def sample_batches(bag: RawBag, topic: Topic, columns: Sequence[str]) -> list[FloatArray]:
    """Return the rows of each message of a topic.

    Raises
    ------
    BagError
        If a message is damaged or has other columns.
    """
    raw = bag.topics[topic]
    batches = []
    for number, message in enumerate(decode(bag.path, raw)):
        try:
            batches.append(read_samples(message, columns))
        except ValueError as error:
            raise BagError(f"bag {bag.path}: message {number} of {raw.name}: {error}") from None
    return batches


def ordered_rows(bag: RawBag, topic: Topic, batches: Sequence[FloatArray]) -> SampleRows:
    """Return the samples of batches in the order of time.

    A batch that was recorded twice counts once, one that came late stands where it belongs. A
    value that is not finite is a missing one: its row is left out.

    Parameters
    ----------
    bag : RawBag
        The bag, for messages.
    topic : Topic
        Where the batches come from.
    batches : sequence of ndarray, shape (k, c)
        Rows that begin with the time [s].

    Raises
    ------
    BagError
        If the batches are of two runs: time begins anew in the middle.
    """
    rows = np.concatenate(batches)
    rows = rows[np.abs(rows[:, 0]) < LARGEST_TIME]
    if (np.diff(rows[:, 0]) <= 0).any():
        _check_one_run(bag, topic, batches)
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        twice = np.diff(rows[:, 0]) == 0
        different = twice & ((rows[1:] != rows[:-1]) & ~np.isnan(rows[1:])).any(axis=1)
        if different.any():
            raise _two_runs(bag, topic, float(rows[1:][different][0, 0]))
        if _limits(bag):  # a lockstep loop that is started again repeats itself
            raise _several_runs(bag, topic, "goes back in time")
        rows = rows[np.concatenate([[True], ~twice])]
    known = (np.abs(rows) < LARGEST_VALUE).all(axis=1)
    return SampleRows(rows if known.all() else rows[known], rows[:, 0].copy())


def run_of_bag(bag: RawBag, number: int) -> RawBag:
    """Return what belongs to one run of a bag that holds several.

    Parameters
    ----------
    bag : RawBag
        A bag with telemetry or measurements.
    number : int
        Which run, from 1.

    Raises
    ------
    BagError
        If the bag does not hold so many runs, or if a message is damaged.
    """
    return select_run(bag, _limits(bag), number)


def rows_of_messages(bag: RawBag) -> SampleRows:
    """Return (t [s], u [V], q3 [m]) at the control rate, for a bag without telemetry.

    Each measurement stands beside the command that answers it; where there is none the voltage
    is NaN.

    Parameters
    ----------
    bag : RawBag
        A bag with measurements.

    Raises
    ------
    BagError
        If a message is damaged, or if stamps begin anew in the middle.
    """
    stamps, positions = joint_values(
        bag.path,
        bag.topics[MEASUREMENT],
        lambda message: read_position(message, PLATFORM_JOINT),
        "position",
    )
    voltages = np.full(stamps.size, np.nan)
    if COMMAND in bag.topics:
        answered, values = joint_values(bag.path, bag.topics[COMMAND], read_voltage, "effort")
        order = np.argsort(answered, kind="stable")
        place = np.searchsorted(answered, stamps, sorter=order)
        place = order[np.minimum(place, answered.size - 1)]
        voltages = np.where(answered[place] == stamps, values[place], np.nan)
    seconds, rest = np.divmod(stamps, 1_000_000_000)
    table = np.stack([seconds + rest / 1e9, voltages, positions], axis=1)
    # A lockstep plant repeats a measurement until it is answered.
    found = ordered_rows(bag, MEASUREMENT, [table[:, [0, 2]]])
    _, first = np.unique(table[:, 0], return_index=True)
    voltages = table[first, 1][np.searchsorted(table[first, 0], found.rows[:, 0])]
    voltages = np.where(np.abs(voltages) < LARGEST_VALUE, voltages, np.nan)
    rows = np.stack([found.rows[:, 0], voltages, found.rows[:, 1]], axis=1)
    return SampleRows(rows, found.times)


def _check_one_run(bag: RawBag, topic: Topic, batches: Sequence[FloatArray]) -> None:
    """Refuse batches that overlap in time without being the same ones."""
    spans = sorted((float(x[0, 0]), float(x[-1, 0])) for x in batches if len(x))
    for earlier, later in pairwise(spans):
        if later[0] <= earlier[1] and later != earlier:
            raise _two_runs(bag, topic, later[0])


def _two_runs(bag: RawBag, topic: Topic, time: float) -> BagError:
    return _several_runs(
        bag, topic, f"has two different samples for t = {time:g} s, as if time began anew"
    )


def _several_runs(bag: RawBag, topic: Topic, fault: str) -> BagError:
    runs = len(_limits(bag)) + 1
    choice = f"holds {runs} runs, choose one with bdt analyze --run 1 to --run {runs}"
    return BagError(
        f"bag {bag.path}: topic {bag.topics[topic].name} {fault}: "
        f"{choice if runs > 1 else 'must hold one run'}"
    )


def _limits(bag: RawBag) -> list[int]:
    """Return where the runs of a bag part [ns].

    Measurements tell the end of a run more closely than batches of telemetry do.
    """
    if MEASUREMENT in bag.topics:
        stamps = message_times(bag, MEASUREMENT, 0.0, 0).stamps
        return run_limits(stamps, bag.topics[MEASUREMENT].received)
    batches = sample_batches(bag, TELEMETRY, TELEMETRY_COLUMNS)
    times = np.array([batch[0, 0] if len(batch) else np.nan for batch in batches])
    times = np.where(np.abs(times) < LARGEST_TIME, times, np.nan)
    return run_limits(times, bag.topics[TELEMETRY].received)
