"""Leaves out of a bag what fits into no run: messages of strangers on the topics of the loop."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_bags.bag_error import BagError
from bdt_bags.reading.bag_reader import RawBag, RawTopic, decode
from bdt_bags.reading.joint_values import joint_values
from bdt_bags.reading.message_runs import STRAY, MessageSpans, runs_of_messages
from bdt_bags.reading.recording_clock import LARGEST_TIME, OTHER_CLOCK
from bdt_bags.reading.run_selection import run_limits
from bdt_bags.reading.sample_rows import LARGEST_VALUE
from bdt_msgs_py.reading import read_position, read_samples, read_voltage
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    COMMAND,
    DEAD_ZONE_JOINT,
    GAP_AGE_JOINT,
    GAP_JOINT,
    GAP_UNCERTAINTY_JOINT,
    MEASUREMENT,
    PLATFORM_JOINT,
    REFERENCE,
    TELEMETRY,
    TELEMETRY_COLUMNS,
    TRUTH,
    TRUTH_COLUMNS,
    VOLTAGE_OFFSET_JOINT,
    Topic,
)

FloatArray = NDArray[np.float64]

AHEAD = 1.0
"""Time [s] by which an estimate may be stated for later than what was received before it: a topic
may overtake another one."""

_COLUMNS = {TELEMETRY: TELEMETRY_COLUMNS, TRUTH: TRUTH_COLUMNS}


def without_strays(bag: RawBag) -> RawBag:
    """Return a bag without what fits into no run, and with the limits of its runs.

    Left out is a message that does not say what its topic is for (other columns, another joint,
    no number), whose time is none of a run's, or that contradicts an earlier one for the same
    time; see :mod:`bdt_bags.reading.message_runs`. A sample that a sensor missed, NaN, stays.

    Parameters
    ----------
    bag : RawBag
        What was read.

    Returns
    -------
    RawBag
        The topics of samples have their batches.

    Raises
    ------
    BagError
        If a message is damaged, if no message of a topic says what the topic is for, or if so
        many do not fit that two sources must have published it.
    """
    topics: dict[Topic, RawTopic] = {}
    left_out: dict[str, list[int]] = {}

    def keep(topic: Topic, raw: RawTopic, kept: NDArray[np.bool_]) -> None:
        topics[topic] = raw if kept.all() else raw.only(kept)
        if not kept.all():
            left_out[raw.name] = [raw.received[k] for k in np.flatnonzero(~kept)]

    main = MEASUREMENT if MEASUREMENT in bag.topics else TELEMETRY
    limits: Sequence[int] = ()
    clock = np.empty((0, 2))
    # The main topic first: the others are compared with its times.
    for topic in sorted(bag.topics, key=lambda topic: topic != main):
        raw = bag.topics[topic]
        if topic in _COLUMNS or topic in (MEASUREMENT, COMMAND):
            raw, spans = _spans(bag.path, topic, raw)
            runs = runs_of_messages(spans)
            _refuse_two_sources(bag.path, raw, spans, runs)
            keep(topic, raw, runs != STRAY)
            if topic is main:
                limits = run_limits(runs, raw.received)
                clock = _clock(spans, runs != STRAY)
        elif topic is REFERENCE:
            keep(topic, raw, _readable(bag.path, raw, _read_reference)[0])
        elif topic is BACKLASH_ESTIMATE:
            readable, stamps = _readable(bag.path, raw, _read_estimate)
            keep(topic, raw, readable & ~_ahead(stamps, raw.received, clock))
        else:
            topics[topic] = raw
    topics = {topic: raw for topic, raw in topics.items() if raw.data}
    return replace(bag, topics=topics, run_limits=limits, left_out=left_out)


def _spans(path: Path, topic: Topic, raw: RawTopic) -> tuple[RawTopic, MessageSpans]:
    """Return a topic with its batches, and the times that its messages tell."""
    if topic in _COLUMNS:
        batches, faults = _batches(path, raw, _COLUMNS[topic])
        raw = replace(raw, batches=batches)
        begins = np.array([rows[0, 0] if len(rows) else np.nan for rows in batches])
        ends = np.array([rows[-1, 0] if len(rows) else np.nan for rows in batches])
    else:
        if topic is MEASUREMENT:
            found = joint_values(
                path, raw, lambda message: read_position(message, PLATFORM_JOINT), "position"
            )
        else:
            found = joint_values(path, raw, read_voltage, "effort")
        faults = dict(found.faults)
        seconds, rest = np.divmod(found.stamps, 1_000_000_000)
        begins = seconds + rest / 1e9
        begins[list(faults)] = np.nan
        ends = begins
    _refuse_nothing_but_faults(path, raw, faults)
    return raw, MessageSpans(begins, ends, raw.received, raw.data)


def _batches(
    path: Path, raw: RawTopic, columns: Sequence[str]
) -> tuple[list[FloatArray], dict[int, str]]:
    """Return the rows of each message, and what is wrong with those that have none."""
    batches, faults = [], {}
    for number, message in enumerate(decode(path, raw)):
        rows = np.empty((0, len(columns)))
        try:
            rows = read_samples(message, columns)
            rows = rows[np.abs(rows[:, 0]) < LARGEST_TIME]
            if not len(rows):
                faults[number] = "no row has a time"
            elif (np.diff(rows[:, 0]) <= 0).any():
                faults[number] = "times do not increase from row to row"
                rows = rows[:0]
        except ValueError as error:
            faults[number] = str(error)
        batches.append(rows)
    return batches, faults


def _readable(
    path: Path, raw: RawTopic, read: Callable[[Any], tuple[int, float]]
) -> tuple[NDArray[np.bool_], FloatArray]:
    """Return which messages hold a number, and the stamps [s] of those that can be read."""
    readable, stamps, faults = np.zeros(len(raw.data), np.bool_), np.zeros(len(raw.data)), {}
    for number, message in enumerate(decode(path, raw)):
        try:
            stamp, value = read(message)
        except ValueError as error:
            faults[number] = str(error)
        else:
            readable[number] = abs(value) < LARGEST_VALUE
            stamps[number] = stamp / 1e9
    _refuse_nothing_but_faults(path, raw, faults)
    return readable, stamps


def _read_reference(message: Any) -> tuple[int, float]:
    return read_position(message, PLATFORM_JOINT)


def _read_estimate(message: Any) -> tuple[int, float]:
    """Return stamp [ns] and gap [rad]; an estimate that tells something twice tells nothing."""
    for joint in (GAP_UNCERTAINTY_JOINT, GAP_AGE_JOINT, DEAD_ZONE_JOINT):
        if joint in message.name:
            read_position(message, joint)
    if VOLTAGE_OFFSET_JOINT in message.name:
        read_voltage(message, VOLTAGE_OFFSET_JOINT)
    return read_position(message, GAP_JOINT)


def _clock(spans: MessageSpans, kept: NDArray[np.bool_]) -> FloatArray:
    """Return rows of (receive time [ns], time of the data [s]) in the order of reception."""
    rows = np.column_stack([np.array(spans.received, np.float64), spans.ends])[kept]
    ordered: FloatArray = rows[np.argsort(rows[:, 0], kind="stable")]
    return ordered


def _ahead(stamps: FloatArray, received: Sequence[int], clock: FloatArray) -> NDArray[np.bool_]:
    """Tell which stamps [s] are ahead of the data that were received before."""
    place = np.searchsorted(clock[:, 0], np.array(received, np.float64), side="right")
    now = np.concatenate([[math.inf], clock[:, 1]])[place]
    ahead: NDArray[np.bool_] = (stamps > now + AHEAD) & (stamps < now + OTHER_CLOCK)
    return ahead


def _refuse_nothing_but_faults(path: Path, raw: RawTopic, faults: dict[int, str]) -> None:
    if len(faults) == len(raw.data):
        raise BagError(f"bag {path}: message 0 of {raw.name}: {faults[0]}")


def _refuse_two_sources(
    path: Path, raw: RawTopic, spans: MessageSpans, runs: NDArray[np.int64]
) -> None:
    strays = int((np.isfinite(spans.begins) & (runs == STRAY)).sum())
    fitting = int((runs != STRAY).sum())
    if 2 * strays > fitting:
        raise BagError(
            f"bag {path}: topic {raw.name} has {strays} messages that do not fit the other "
            f"{fitting}: must be of one source"
        )
