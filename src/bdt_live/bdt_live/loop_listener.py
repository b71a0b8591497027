"""Hears everything that a loop says: rows for the page, timing, the last minute for a bag."""

import contextlib
import time
from collections import deque
from typing import Any, Protocol

from rclpy.node import Node
from rclpy.serialization import deserialize_message

from bdt_bags.recorder.topic_choice import ChosenTopic, project_topics
from bdt_bags.writing.topic_metadata import SerializedMessage
from bdt_live.extremes import RowMaker
from bdt_live.held_parameters import HeldParameters
from bdt_live.loop_timing import LoopTiming
from bdt_live.recent_messages import Held, LastMessage, RecentMessages
from bdt_live.short_looks import ShortLooks
from bdt_msgs_py.message_checks import (
    check_estimate,
    check_position,
    check_stamp,
    check_telemetry_times,
)
from bdt_msgs_py.reading import NANOSECONDS_PER_SECOND, read_position, read_samples
from bdt_msgs_py.rejection import MessageRejectedError
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    COMMAND,
    GAP_UNCERTAINTY_JOINT,
    MARK,
    MEASUREMENT,
    PARAMETER_EVENTS,
    REFERENCE,
    TELEMETRY,
    TRUTH,
    TRUTH_COLUMNS,
    Topic,
)

TIMED = 4
"""Measurements and commands of a frame whose times are looked at; all of them would be work."""


MOST_MARKS = 100
"""Marks that are kept; of more, the oldest are forgotten."""


class EventListener(Protocol):
    """Somebody who wants to know of parameters that change."""

    def take_event(self, event: Any) -> None:
        """Take an event."""


class LoopListener:
    """Subscriptions of all topics of a loop.

    Parameters
    ----------
    node : rclpy.node.Node
        Node that listens.
    events : list of EventListener
        Get the parameter events.
    spares_loop : bool
        Whether to hear measurements for a moment now and then only, and to keep none: each of
        their subscribers lets the controller have them later.

    Attributes
    ----------
    messages : int
        Number of messages taken.
    rows : RowMaker
        Makes rows of what was heard.
    timing : LoopTiming
        Rate and latency.
    recent : RecentMessages
        The last minute.
    end : float or None
        Time of the newest telemetry [s]; None before the first one.
    marks : deque of float
        What somebody has marked since time began [s].
    """

    def __init__(self, node: Node, events: list[EventListener], *, spares_loop: bool) -> None:
        self.messages = 0
        self.rows, self.timing, self.recent = RowMaker(), LoopTiming(), RecentMessages()
        self.end: float | None = None
        self.marks: deque[float] = deque(maxlen=MOST_MARKS)
        self._events = events
        self._commands = self._commanded = 0
        self._looks: ShortLooks | None = None
        self._timed: dict[str, deque[tuple[int, bytes]]] = {
            topic.name: deque(maxlen=TIMED) for topic in (MEASUREMENT, COMMAND)
        }
        readers = {
            TELEMETRY: self._take_telemetry,
            TRUTH: self._take_truth,
            REFERENCE: self._take_reference,
            BACKLASH_ESTIMATE: self._take_estimate,
            PARAMETER_EVENTS: self._take_event,
            MARK: self._take_mark,
        }
        chosen, _ = project_topics(node, "")
        self._types = {each.topic: each.message_type for each in chosen}
        for each in chosen:
            if spares_loop and each.topic is MEASUREMENT:
                self._looks = ShortLooks(node, each, self._take_measurement)
            else:
                self._subscribe(node, each, readers.get(each.topic) if each.topic else None)

    def look(self) -> None:
        """Look at the times of some messages, and count them."""
        if self._looks is not None:
            self._looks.look(time.monotonic())
        self.timing.count(self._commands, self._commanded, time.time_ns())
        self._commands = 0
        for topic, note in ((MEASUREMENT, self.timing.measured), (COMMAND, self.timing.commanded)):
            waiting = self._timed[topic.name]
            while waiting:
                sent, data = waiting.popleft()
                with contextlib.suppress(MessageRejectedError):
                    message = deserialize_message(data, self._types[topic])
                    note(check_stamp(message.header.stamp), sent)

    def _subscribe(self, node: Node, chosen: ChosenTopic, read: Any) -> None:
        topic = chosen.topic
        number = self.recent.add_topic(chosen.recorded, _held_of(topic))
        timed = self._timed.get(topic.name) if topic else None

        def take(data: bytes, info: dict[str, int]) -> None:
            self.messages += 1
            sent = info["source_timestamp"]
            received = info["received_timestamp"] or sent or time.time_ns()
            self.recent.add(SerializedMessage(number, received, received, data))
            if timed is not None:
                timed.append((sent, data))
                if topic is COMMAND:
                    self._commands, self._commanded = self._commands + 1, sent
            elif read is not None:
                # A stray message is for the nodes of the loop to complain about.
                with contextlib.suppress(MessageRejectedError):
                    read(deserialize_message(data, chosen.message_type))

        node.create_subscription(
            chosen.message_type, chosen.recorded.name, take, chosen.profile, raw=True
        )

    def _take_measurement(self, data: bytes, info: dict[str, int]) -> None:
        self.messages += 1
        self._timed[MEASUREMENT.name].append((info["source_timestamp"], data))

    def _take_telemetry(self, message: Any) -> None:
        rows = check_telemetry_times(message)
        self.rows.take_telemetry(rows)
        if self.end is not None and rows[0, 0] < self.end:
            self.marks.clear()  # time begins anew
        self.end = float(rows[-1, 0])

    def _take_truth(self, message: Any) -> None:
        rows = read_samples(message, TRUTH_COLUMNS)
        if len(rows):
            self.rows.take_truth(rows)

    def _take_reference(self, message: Any) -> None:
        stamp, position = check_position(message)
        self.rows.hold("reference", stamp / NANOSECONDS_PER_SECOND, position)

    def _take_estimate(self, message: Any) -> None:
        stamp, gap = check_estimate(message)
        uncertainty = None
        if GAP_UNCERTAINTY_JOINT in message.name:
            _, uncertainty = read_position(message, GAP_UNCERTAINTY_JOINT)
        for name, value in (("estimate", gap), ("uncertainty", uncertainty)):
            self.rows.hold(name, stamp / NANOSECONDS_PER_SECOND, value)

    def _take_mark(self, message: Any) -> None:
        self.marks.append(check_stamp(message.stamp) / NANOSECONDS_PER_SECOND)

    def _take_event(self, message: Any) -> None:
        for listener in self._events:
            listener.take_event(message)


def _held_of(topic: Topic | None) -> Held | None:
    """Return what of the messages of a topic holds on."""
    if topic is PARAMETER_EVENTS:
        return HeldParameters()
    return LastMessage() if topic is not None and topic.transient_local else None
