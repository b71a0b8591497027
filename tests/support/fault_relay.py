"""A relay between the nodes of a loop, which loses, doubles, delays and garbles their messages."""

import math
import random
import time
from collections import Counter, deque
from functools import partial

from rclpy.clock import Clock as RosClock
from rclpy.clock import ClockType
from rclpy.node import Node
from rclpy.serialization import deserialize_message, serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from bdt_msgs_py.qos import publisher_profile, qos_profile
from bdt_msgs_py.reading import nanoseconds_from_stamp
from bdt_msgs_py.topics import CLOCK, COMMAND, MEASUREMENT, TELEMETRY
from bdt_msgs_py.writing import stamp_from_nanoseconds

CHANNELS = {
    "measurement": (MEASUREMENT, JointState, "/sent/measurement"),
    "command": (COMMAND, JointState, "/sent/command"),
    "telemetry": (TELEMETRY, Float64MultiArray, "/sent/telemetry"),
    "clock": (CLOCK, Clock, "/sent/clock"),
}
"""Topic, type, and the name under which its sender publishes it."""
DELAY = 0.05
"""Wall time [s] by which delayed messages are late, and those out of order at most."""
STEP = 5_000_000_000
"""Time [ns] by which the clock steps."""


class FaultRelay(Node):
    """Passes messages on, with the faults of a schedule.

    Attributes
    ----------
    now : float
        Time by the newest measurement that was sent [s], since the first one.
    origin : float
        Time of the first one [s].
    said : dict of str to Counter of bytes
        How often each message was passed on, by topic name.
    """

    def __init__(self, schedule, **node_arguments):
        super().__init__("relay", **node_arguments)
        self._faults = {
            name: [fault for fault in schedule if fault.target == name] for name in CHANNELS
        }
        self._draw = random.Random(str(schedule))  # noqa: S311
        self._held, self._late = {}, deque()
        self._ways = {}
        self.now, self.origin = 0.0, None
        self.said = {topic.name: Counter() for topic, _, _ in CHANNELS.values()}
        for name, (topic, kind, source) in CHANNELS.items():
            publisher = self.create_publisher(kind, topic.name, publisher_profile(topic))
            self._ways[name] = partial(self._say, publisher, self.said[topic.name])
            self.create_subscription(
                kind, source, partial(self._relay, name), qos_profile(topic), raw=True
            )
        self.create_timer(0.01, self._send_late, clock=RosClock(clock_type=ClockType.STEADY_TIME))

    @staticmethod
    def _say(publisher, said, message):
        said[message] += 1
        publisher.publish(message)

    def _relay(self, name, message):
        if name == "measurement":
            header = deserialize_message(message, JointState).header
            stamp = nanoseconds_from_stamp(header.stamp) * 1e-9
            self.origin = stamp if self.origin is None else self.origin
            self.now = max(self.now, stamp - self.origin)
        send = self._ways[name]
        for fault in self._faults[name]:
            if fault.time <= self.now < fault.end and self._draw.random() < fault.share:
                self._spoil(name, fault.kind, message)
                return
        send(message)
        self._send_held(name)

    def _send_held(self, name):
        if name in self._held:
            _, held = self._held.pop(name)
            self._ways[name](held)

    def _spoil(self, name, kind, message):
        send = self._ways[name]
        if kind == "duplicate":
            send(message)
            send(message)
        elif kind == "delay":
            self._late.append((time.monotonic() + DELAY, name, message))
        elif kind == "reorder":
            self._send_held(name)
            self._held[name] = time.monotonic() + DELAY, message
        elif kind == "nan":
            _, message_type, _ = CHANNELS[name]
            spoiled = garbled(name, deserialize_message(message, message_type))
            send(bytes(serialize_message(spoiled)))
            send(message)
        elif kind == "step":
            sign = self._draw.choice((-1, 1))
            clock = deserialize_message(message, Clock).clock
            stamp = max(nanoseconds_from_stamp(clock) + sign * STEP, 0)
            send(bytes(serialize_message(Clock(clock=stamp_from_nanoseconds(stamp)))))

    def _send_late(self):
        while self._late and self._late[0][0] <= time.monotonic():
            _, name, message = self._late.popleft()
            self._ways[name](message)
        # Nobody may send a next one before this one has come.
        for name in [name for name, (due, _) in self._held.items() if due <= time.monotonic()]:
            self._send_held(name)


def garbled(name, message):
    """Return a copy of a message with a number that is none."""
    if name == "telemetry":
        data = list(message.data)
        data[len(data) // 2] = math.nan
        return Float64MultiArray(layout=message.layout, data=data)
    number = [math.nan]
    if name == "command":
        return JointState(header=message.header, name=message.name, effort=number)
    return JointState(header=message.header, name=message.name, position=number)
