"""Recording of one run as numpy arrays, all on the clock of the telemetry."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bdt_bringup.bags.bag_reader import BagError, RawBag, decode, read_bag
from bdt_bringup.bags.parameter_log import (
    diagnosed_dead_zones,
    parameter_changes,
    recorded_pitch,
)
from bdt_bringup.bags.recording_clock import (
    LARGEST_TIME,
    header_stamps,
    on_telemetry_clock,
    reception_clock,
)
from bdt_bringup.run_signals import RunSignals
from bdt_msgs_py.reading import read_position, read_samples
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    COMMAND,
    DIAGNOSTICS,
    GAP_JOINT,
    MEASUREMENT,
    PARAMETER_EVENTS,
    PLATFORM_JOINT,
    REFERENCE,
    TELEMETRY,
    TELEMETRY_COLUMNS,
    TRUTH,
    TRUTH_COLUMNS,
    Topic,
)
from bdt_plant.lead_screw import LeadScrewParameters

FloatArray = NDArray[np.float64]

EPOCH_TIMES = 1e8
"""Times [s] beyond this (three years) are on a clock that counts from 1970."""

LARGEST_VALUE = 1e100
"""What is beyond this has left physics, and soon floating point; it counts as not finite."""

SHORTEST_SAMPLE_TIME = 1e-9
"""Telemetry is not sampled faster than this [s]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Recording(RunSignals):
    """What a bag says about one run.

    The pitch is the paper's unless the bag tells another.

    Attributes
    ----------
    path : Path
        The bag.
    batch_rows : int
        Median number of rows of a telemetry message.
    reconfigurations : int
        Number of times that the dead zone was set while the controller ran.
    measurement_stamps, command_stamps : ndarray, shape (k,)
        Stamps [s] in the order of the bag.
    receive_clock : ndarray, shape (k, 2)
        Rows of (receive time [s], time of the data [s]) of measurements or, without them, of
        telemetry.
    message_counts : mapping of str to int
        Number of messages by topic.
    """

    path: Path
    batch_rows: int
    reconfigurations: int
    measurement_stamps: FloatArray
    command_stamps: FloatArray
    receive_clock: FloatArray
    message_counts: Mapping[str, int]

    @property
    def real_time_factor(self) -> float | None:
        """Time of the data per wall-clock time of its reception; None when that is unknown.

        The first time is taken when it was received last: a lockstep plant repeats its first
        measurement until everybody is there.
        """
        if not len(self.receive_clock):
            return None
        received, time = self.receive_clock.T
        begin, end = received[time == time.min()].max(), received[time == time.max()].min()
        return float(np.ptp(time) / (end - begin)) if end > begin else None


def load_recording(path: Path) -> Recording:
    """Load a bag.

    Parameters
    ----------
    path : Path
        See :func:`bdt_bringup.bags.bag_reader.read_bag`.

    Raises
    ------
    BagError
        For everything that is wrong with the bag.
    """
    bag = read_bag(path)
    batches = _sample_batches(bag, TELEMETRY, TELEMETRY_COLUMNS)
    telemetry = _ordered_rows(bag, TELEMETRY, batches)
    if len(telemetry) < 2:
        raise BagError(
            f"bag {bag.path}: topic {bag.topics[TELEMETRY].name} has {len(telemetry)} valid "
            "samples: must have at least two"
        )
    if np.median(np.diff(telemetry[:, 0])) < SHORTEST_SAMPLE_TIME:
        raise BagError(
            f"bag {bag.path}: topic {bag.topics[TELEMETRY].name} is sampled every "
            f"{np.median(np.diff(telemetry[:, 0])):g} s: must be at least 1e-9 s"
        )
    origin = float(np.floor(telemetry[0, 0])) if telemetry[0, 0] > EPOCH_TIMES else 0.0
    telemetry[:, 0] -= origin
    truth = None
    if TRUTH in bag.topics and bag.topics[TRUTH].data:
        rows = _ordered_rows(bag, TRUTH, _sample_batches(bag, TRUTH, TRUTH_COLUMNS))
        rows[:, 0] -= origin
        truth = rows if len(rows) else None
    stamps = {topic: header_stamps(bag, topic, origin) for topic in (MEASUREMENT, COMMAND)}
    receive_clock = reception_clock(bag, batches, stamps[MEASUREMENT], origin)
    dead_zones, reconfigurations, pitch = _dead_zone_log(bag, telemetry, receive_clock, origin)
    return Recording(
        path=bag.path,
        time_origin=origin,
        telemetry=telemetry,
        batch_rows=int(np.median([len(batch) for batch in batches if len(batch)])),
        truth=truth,
        reference=_positions(bag, REFERENCE, PLATFORM_JOINT, telemetry, receive_clock, origin),
        estimates=_positions(bag, BACKLASH_ESTIMATE, GAP_JOINT, telemetry, receive_clock, origin),
        dead_zones=dead_zones,
        reconfigurations=reconfigurations,
        pitch=pitch,
        measurement_stamps=stamps[MEASUREMENT],
        command_stamps=stamps[COMMAND],
        receive_clock=receive_clock,
        message_counts=bag.message_counts,
    )


def _sample_batches(bag: RawBag, topic: Topic, columns: Sequence[str]) -> list[FloatArray]:
    raw = bag.topics[topic]
    batches = []
    for number, message in enumerate(decode(bag.path, raw)):
        try:
            batches.append(read_samples(message, columns))
        except ValueError as error:
            raise BagError(f"bag {bag.path}: message {number} of {raw.name}: {error}") from None
    return batches


def _ordered_rows(bag: RawBag, topic: Topic, batches: list[FloatArray]) -> FloatArray:
    """Return finite rows in the order of time; a batch that was recorded twice counts once."""
    rows = np.concatenate(batches)
    finite = (np.abs(rows) < LARGEST_VALUE).all(axis=1) & (np.abs(rows[:, 0]) < LARGEST_TIME)
    if not finite.all():
        rows = rows[finite]
    if (np.diff(rows[:, 0]) <= 0).any():
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        twice = np.diff(rows[:, 0]) == 0
        different = twice & (rows[1:] != rows[:-1]).any(axis=1)
        if different.any():
            time = rows[1:][different][0, 0]
            raise BagError(
                f"bag {bag.path}: topic {bag.topics[topic].name} has two different samples for "
                f"t = {time:g} s: must hold one run"
            )
        rows = rows[np.concatenate([[True], ~twice])]
    return rows


def _positions(
    bag: RawBag,
    topic: Topic,
    joint: str,
    telemetry: FloatArray,
    receive_clock: FloatArray,
    origin: float,
) -> FloatArray:
    """Return rows of (time [s], position) of a topic, in the order of time."""
    raw = bag.topics.get(topic)
    if raw is None or not raw.data:
        return np.empty((0, 2))
    rows = []
    for number, message in enumerate(decode(bag.path, raw)):
        try:
            rows.append(read_position(message, joint))
        except ValueError as error:
            raise BagError(f"bag {bag.path}: message {number} of {raw.name}: {error}") from None
    stamps = [stamp for stamp, _ in rows]
    times = on_telemetry_clock(stamps, raw.received, telemetry, receive_clock, origin)
    values = np.array([position for _, position in rows])
    kept = np.abs(values) < LARGEST_VALUE  # the nodes ignore what is not finite
    order = np.argsort(times[kept], kind="stable")
    return np.stack([times[kept], values[kept]], axis=1)[order]


def _dead_zone_log(
    bag: RawBag, telemetry: FloatArray, receive_clock: FloatArray, origin: float
) -> tuple[FloatArray, int, float]:
    """Return dead zones over time, number of reconfigurations and pitch."""

    def times(stamps: list[int], received: list[int]) -> FloatArray:
        return on_telemetry_clock(stamps, received, telemetry, receive_clock, origin)

    changes, reconfigurations = np.empty((0, 2)), 0
    pitch = LeadScrewParameters().pitch
    namespace = bag.topics[TELEMETRY].namespace
    raw = bag.topics.get(PARAMETER_EVENTS)
    if raw is not None:
        events = decode(bag.path, raw)
        pitch = recorded_pitch(events, namespace) or pitch
        log = parameter_changes(bag.path, events, raw.received, namespace)
        reconfigurations = sum(not change.initial for change in log)
        if log:
            when = times([change.stamp for change in log], [change.received for change in log])
            changes = np.stack([when, [change.value for change in log]], axis=1)
    raw = bag.topics.get(DIAGNOSTICS)
    if raw is not None and (not len(changes) or not log[0].initial):
        # Parameter events are volatile: a recorder that came late has missed the first value.
        seen = diagnosed_dead_zones(decode(bag.path, raw), raw.received, namespace)
        when = times([0] * len(seen), [received for received, _ in seen])
        rows = np.array([(t, value) for t, (_, value) in zip(when, seen, strict=True)])
        rows = rows.reshape(-1, 2)
        if len(changes):
            rows = rows[rows[:, 0] < changes[0, 0]]
        changes = np.concatenate([_value_changes(rows), changes])
    return changes[np.argsort(changes[:, 0], kind="stable")], reconfigurations, pitch


def _value_changes(rows: FloatArray) -> FloatArray:
    """Return the rows whose value differs from the row before."""
    if not len(rows):
        return rows
    kept: FloatArray = rows[np.concatenate([[True], np.diff(rows[:, 1]) != 0])]
    return kept
