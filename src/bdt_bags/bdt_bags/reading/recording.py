"""Recording of one run as numpy arrays, all on the clock of the telemetry."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_bags.bag_error import BagError
from bdt_bags.reading.bag_reader import RawBag, decode, read_bag
from bdt_bags.reading.joint_positions import (
    dead_zone_requests,
    held_gaps,
    joint_positions,
    voltage_offset_requests,
)
from bdt_bags.reading.marks import recorded_marks
from bdt_bags.reading.missing_data import has_parameter_events, missing_data
from bdt_bags.reading.parameter_log import (
    diagnosed_dead_zones,
    parameter_changes,
    recorded_parameters,
    recorded_pitch,
    value_changes,
)
from bdt_bags.reading.recording_clock import (
    MessageTimes,
    batch_times,
    first_reception,
    message_times,
    on_telemetry_clock,
)
from bdt_bags.reading.run_selection import select_run
from bdt_bags.reading.sample_rows import ordered_rows, rows_of_messages
from bdt_bags.reading.stray_messages import without_strays
from bdt_bags.reading.topic_selection import TopicSelection
from bdt_bags.reading.twin_decisions import TwinDecision, recorded_decisions
from bdt_bags.run_signals import RunSignals
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    COMMAND,
    DIAGNOSTICS,
    GAP_JOINT,
    GAP_UNCERTAINTY_JOINT,
    MEASUREMENT,
    PARAMETER_EVENTS,
    PLATFORM_JOINT,
    REFERENCE,
    TELEMETRY,
    TRUTH,
    TWIN_NODE,
    Topic,
)

FloatArray = NDArray[np.float64]

EPOCH_TIMES = 1e8
"""Times [s] beyond this (three years) are on a clock that counts from 1970."""

SHORTEST_SAMPLE_TIME = 1e-9
"""Telemetry is not sampled faster than this [s]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Recording(RunSignals):
    """What a bag says about one run.

    A sample whose position or voltage is not finite is missing: it has no row in the telemetry.

    Attributes
    ----------
    path : Path
        The bag.
    sample_times : ndarray, shape (m,)
        Times of all samples [s], missing ones included.
    batch_rows : int
        Median number of rows of a telemetry message; 0 for a bag without telemetry, whose rows
        are those of measurements and commands.
    reconfigurations : int or None
        Number of times that the dead zone was set while the controller ran; None when the bag has
        no parameter events, which tell it.
    measurements, commands, batches : MessageTimes
        Times of the messages of measurement, command and telemetry.
    message_counts : mapping of str to int
        Number of messages by topic.
    left_out : mapping of str to int
        Number of messages that fit into no run and are left out, by topic name.
    missing : tuple of str
        What the bag lacks, each with what follows from it.
    twin_parameters : mapping of str
        Parameters of the twin by name, as far as the bag tells them.
    decisions : tuple of TwinDecision
        What the twin has decided by simulation, in the order of time.
    marks : tuple of float
        Moments that somebody has marked [s], in the order of time.
    """

    path: Path
    sample_times: FloatArray
    batch_rows: int
    reconfigurations: int | None
    measurements: MessageTimes
    commands: MessageTimes
    batches: MessageTimes
    message_counts: Mapping[str, int]
    left_out: Mapping[str, int] = field(default_factory=dict)
    missing: tuple[str, ...] = ()
    twin_parameters: Mapping[str, bool | int | float | str] = field(default_factory=dict)
    decisions: tuple[TwinDecision, ...] = ()
    marks: tuple[float, ...] = ()

    @property
    def missing_samples(self) -> int:
        """Number of samples without position or voltage."""
        return len(self.sample_times) - len(self.telemetry)

    @property
    def receive_clock(self) -> MessageTimes:
        """Which time of the data was received when: measurements or, without them, telemetry."""
        return self.measurements if len(self.measurements.stamps) else self.batches

    @property
    def real_time_factor(self) -> float | None:
        """Time of the data per wall-clock time of its reception; None when that is unknown.

        The first time is taken when it was received last: a lockstep plant repeats its first
        measurement until everybody is there.
        """
        time, received = self.receive_clock
        if not len(time):
            return None
        begin, end = received[time == time.min()].max(), received[time == time.max()].min()
        return float(np.ptp(time) / (end - begin)) if end > begin else None


def load_recording(
    path: Path, selection: TopicSelection | None = None, run: int | None = None
) -> Recording:
    """Load a bag.

    Parameters
    ----------
    path : Path
        See :func:`bdt_bags.reading.bag_reader.read_bag`.
    selection : TopicSelection, optional
        Which loop and which topics are meant where the bag does not tell.
    run : int, optional
        Which run is meant, from 1, of a bag that holds several; None for the only one.

    Raises
    ------
    BagError
        For everything that is wrong with the bag.
    """
    bag = select_run(without_strays(read_bag(path, selection)), run)
    if TELEMETRY in bag.topics:
        source, batches = TELEMETRY, bag.topics[TELEMETRY].batches
        samples = ordered_rows(bag.topics[TELEMETRY])
    else:
        source, batches = MEASUREMENT, []
        samples = rows_of_messages(bag)
    telemetry = samples.rows
    _check_sampling(bag, source, telemetry)
    origin = float(np.floor(telemetry[0, 0])) if telemetry[0, 0] > EPOCH_TIMES else 0.0
    telemetry[:, 0] -= origin
    begin = first_reception(bag)
    measurements, commands = (
        message_times(bag, topic, origin, begin) for topic in (MEASUREMENT, COMMAND)
    )
    sent = batch_times(bag, TELEMETRY, origin, begin)
    clock = _Clock(telemetry, measurements if len(measurements.stamps) else sent, origin, begin)
    raw = bag.topics.get(PARAMETER_EVENTS)
    events = [] if raw is None else decode(bag.path, raw)
    namespace = bag.topics[source].namespace
    dead_zones, reconfigurations = _dead_zone_log(bag, namespace, events, clock)
    return Recording(
        path=bag.path,
        time_origin=origin,
        telemetry=telemetry,
        sample_times=samples.times - origin,
        batch_rows=int(np.median([len(x) for x in batches])) if batches else 0,
        truth=_truth(bag, origin),
        reference=joint_positions(bag, REFERENCE, PLATFORM_JOINT, clock.times),
        estimates=joint_positions(bag, BACKLASH_ESTIMATE, GAP_JOINT, clock.times),
        uncertainties=joint_positions(
            bag, BACKLASH_ESTIMATE, GAP_UNCERTAINTY_JOINT, clock.times, optional=True
        ),
        requests=dead_zone_requests(bag, clock.times),
        voltage_offset_requests=voltage_offset_requests(bag, clock.times),
        held_gaps=held_gaps(bag, clock.times),
        dead_zones=dead_zones,
        reconfigurations=reconfigurations,
        pitch=recorded_pitch(events, namespace),
        twin_parameters=recorded_parameters(events, f"{namespace}/{TWIN_NODE}"),
        decisions=recorded_decisions(bag, namespace, clock.times),
        marks=recorded_marks(bag, clock.times),
        measurements=measurements,
        commands=commands,
        batches=sent,
        message_counts=bag.message_counts,
        left_out={name: len(times) for name, times in sorted(bag.left_out.items())},
        missing=missing_data(bag, samples),
    )


class _Clock(NamedTuple):
    """What it takes to bring a stamp to the clock of the telemetry."""

    telemetry: FloatArray
    receive_clock: MessageTimes
    origin: float
    begin: int

    def times(self, stamps: Sequence[int], received: Sequence[int]) -> FloatArray:
        return on_telemetry_clock(
            stamps, received, self.telemetry, self.receive_clock, self.origin, self.begin
        )


def _check_sampling(bag: RawBag, source: Topic, telemetry: FloatArray) -> None:
    if len(telemetry) < 2:
        raise BagError(
            f"bag {bag.path}: topic {bag.topics[source].name} has {len(telemetry)} valid "
            "samples: must have at least two"
        )
    sample_time = np.median(np.diff(telemetry[:, 0]))
    if sample_time < SHORTEST_SAMPLE_TIME:
        raise BagError(
            f"bag {bag.path}: topic {bag.topics[source].name} is sampled every "
            f"{sample_time:g} s: must be at least {SHORTEST_SAMPLE_TIME:g} s"
        )


def _truth(bag: RawBag, origin: float) -> FloatArray | None:
    if TRUTH not in bag.topics:
        return None
    rows = ordered_rows(bag.topics[TRUTH]).rows
    rows[:, 0] -= origin
    return rows if len(rows) else None


def _dead_zone_log(
    bag: RawBag, namespace: str, events: Sequence[Any], clock: _Clock
) -> tuple[FloatArray, int | None]:
    """Return dead zones over time and number of reconfigurations, None if that is unknown."""
    changes, log = np.empty((0, 2)), []
    raw = bag.topics.get(PARAMETER_EVENTS)
    if raw is not None:
        log = parameter_changes(bag.path, events, raw.received, namespace)
    if log:
        when = clock.times([change.stamp for change in log], [change.received for change in log])
        changes = np.stack([when, [change.value for change in log]], axis=1)
    raw = bag.topics.get(DIAGNOSTICS)
    if raw is not None and (not len(changes) or not log[0].initial):
        # Parameter events are volatile: a recorder that came late has missed the first value.
        seen = diagnosed_dead_zones(decode(bag.path, raw), raw.received, namespace)
        if len(changes):
            seen = [row for row in seen if row[0] < log[0].received]
        when = clock.times([0] * len(seen), [received for received, _ in seen])
        rows = np.array([(t, value) for t, (_, value) in zip(when, seen, strict=True)])
        rows = rows.reshape(-1, 2)
        changes = np.concatenate([value_changes(rows), changes])
    count = sum(not change.initial for change in log) if has_parameter_events(bag) else None
    return changes[np.argsort(changes[:, 0], kind="stable")], count
