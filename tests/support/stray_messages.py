"""Messages that do not belong: every topic, every field, every fault, for the tests of the loop."""

import copy
import math
from array import array
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.msg import Parameter, ParameterEvent, ParameterValue

from bdt_msgs_py.reading import read_samples
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    CLOCK,
    COMMAND,
    DEAD_ZONE_PARAMETER,
    DIAGNOSTICS,
    MEASUREMENT,
    PARAMETER_EVENTS,
    PROGRESS,
    REFERENCE,
    TELEMETRY,
    TELEMETRY_COLUMNS,
    TRUTH,
    Topic,
)
from bdt_msgs_py.writing import sample_message, stamp_from_nanoseconds

PERIOD = 2_000_000
SECOND = 1_000_000_000
LATEST = (2**31 - 1) * SECOND


class Stray(NamedTuple):
    """A stray message.

    Attributes
    ----------
    topic : Topic
        Where it is sent.
    field, fault : str
        What is wrong, in the words of the table.
    build : callable
        Makes it of a genuine message and the stamp of the newest measurement [ns].
    count : int
        How many are sent, each one right after a genuine message.
    """

    topic: Topic
    field: str
    fault: str
    build: Callable[[Any, int], Any]
    count: int = 1

    @property
    def name(self) -> str:
        """The stray in one line."""
        return f"{self.topic.name}: {self.field}: {self.fault}"


def _changed(change: Callable[[Any, int], object]) -> Callable[[Any, int], Any]:
    def build(genuine: Any, now: int) -> Any:
        message = copy.deepcopy(genuine)
        change(message, now)
        return message

    return build


def _times(choose: Callable[[Any], Any]) -> list[tuple[str, Callable[[Any, int], Any]]]:
    """Return faults of the stamp that `choose` returns the owner and the field's name of."""

    def setting(time: Callable[[int], Time]) -> Callable[[Any, int], Any]:
        def change(message: Any, now: int) -> None:
            owner, field = choose(message)
            setattr(owner, field, time(now))

        return _changed(change)

    return [
        ("negative", setting(lambda _: Time(sec=-1, nanosec=0))),
        ("huge", setting(lambda _: stamp_from_nanoseconds(LATEST))),
        ("a second and more of nanoseconds", setting(lambda _: Time(sec=0, nanosec=2**32 - 1))),
        ("empty", setting(lambda _: Time())),
        ("from the past", setting(lambda now: stamp_from_nanoseconds(now - SECOND))),
        ("from the future", setting(lambda now: stamp_from_nanoseconds(now + SECOND))),
        ("unit wrong by 1000", setting(lambda now: stamp_from_nanoseconds(1000 * now))),
    ]


def _joint_state(topic: Topic, quantity: str, jump: float, at: Callable[[int], int]) -> list[Stray]:
    """Return the faults of a JointState; those of its value come with a stamp that is right."""

    def value(new: Callable[[float], float]) -> Callable[[Any, int], Any]:
        def change(message: Any, now: int) -> None:
            message.header.stamp = stamp_from_nanoseconds(at(now))
            old = getattr(message, quantity)
            setattr(message, quantity, array("d", [new(old[0]), *old[1:]]))

        return _changed(change)

    def names(new: Callable[[list[str]], list[str]]) -> Callable[[Any, int], Any]:
        return _changed(lambda message, _: setattr(message, "name", new(list(message.name))))

    def length(new: Callable[[Any], list[float]]) -> Callable[[Any, int], Any]:
        return _changed(
            lambda message, _: setattr(
                message, quantity, array("d", new(getattr(message, quantity)))
            )
        )

    faults = [
        (quantity, "NaN", value(lambda _: math.nan)),
        (quantity, "infinite", value(lambda _: -math.inf)),
        (quantity, "huge", value(lambda _: 1e300)),
        (quantity, "a jump", value(lambda old: old + jump)),
        (quantity, "unit wrong by 1000", value(lambda old: 1000.0 * (old or jump))),
        (quantity, "empty", length(lambda _: [])),
        (quantity, "wrong length", length(lambda old: [*old, *old])),
        ("name", "empty", names(lambda _: [])),
        ("name", "wrong", names(lambda old: ["elbow", *old[1:]])),
        ("name", "twice", names(lambda old: [old[0], *old])),
    ]
    stamps = _times(lambda message: (message.header, "stamp"))
    return [
        *(Stray(topic, *fault) for fault in faults),
        *(Stray(topic, "stamp", *fault) for fault in stamps),
        Stray(topic, "all", "twice", lambda genuine, _: genuine),
    ]


def _second_source(topic: Topic, build: Callable[[Any, int], Any], count: int = 50) -> Stray:
    return Stray(topic, "all", "from a second source", build, count)


def _competing_reading(message: Any, _: int) -> None:
    message.position = array("d", [message.position[0] + 5e-3])


def _competing_command(message: Any, now: int) -> None:
    message.header.stamp = stamp_from_nanoseconds(now)
    message.header.frame_id = "/somebody"
    message.effort = array("d", [24.0])


def _stranger(stray: Stray) -> Stray:
    """Return a stray command whose sender does not pretend to be the controller."""

    def build(genuine: Any, now: int) -> Any:
        message = stray.build(genuine, now)
        message.header.frame_id = "/somebody"
        return message

    return stray if stray.fault == "twice" else stray._replace(build=build)


def _reversed_reference(message: Any, now: int) -> None:
    message.header.stamp = stamp_from_nanoseconds(now)
    message.position = array("d", [-message.position[0]])


def _telemetry() -> list[Stray]:
    def rows(change: Callable[[Any], object]) -> Callable[[Any, int], Any]:
        def build(genuine: Any, _: int) -> Any:
            changed = read_samples(genuine, TELEMETRY_COLUMNS).copy()
            # As if it were the next batch: only what is changed is wrong.
            changed[:, 0] += 1e-4 * len(changed) * 2
            change(changed)
            return sample_message(changed, TELEMETRY_COLUMNS)

        return build

    def column(index: int, new: Callable[[Any], Any]) -> Callable[[Any, int], Any]:
        def change(found: Any) -> None:
            found[:, index] = new(found[:, index])

        return rows(change)

    def layout(change: Callable[[Any], object]) -> Callable[[Any, int], Any]:
        return _changed(lambda message, _: change(message))

    faults = [
        ("t", "NaN", column(0, lambda t: t * math.nan)),
        ("t", "infinite", column(0, lambda t: t + math.inf)),
        ("t", "huge", column(0, lambda t: t + 3e9)),
        ("t", "1e300", column(0, lambda t: t * 1e300)),
        ("t", "-1e300", column(0, lambda t: -1e300 * (1 + t))),
        ("t", "negative", column(0, lambda t: -t)),
        ("t", "going back", column(0, lambda t: t[::-1])),
        ("t", "from the past", column(0, lambda t: t - t[0])),
        ("t", "from the future", column(0, lambda t: t + 5.0)),
        ("t", "unit wrong by 1000", column(0, lambda t: 1000.0 * t)),
        ("u", "NaN", column(1, lambda u: u * math.nan)),
        ("u", "huge", column(1, lambda u: u + 1e300)),
        ("q3", "infinite", column(2, lambda q: q - math.inf)),
        ("q3", "1e300", column(2, lambda q: q + 1e300)),
        ("data", "empty", lambda *_: sample_message(np.empty((0, 3)), TELEMETRY_COLUMNS)),
        ("data", "wrong length", layout(lambda m: setattr(m, "data", m.data[:-1]))),
        ("layout.dim", "empty", layout(lambda m: setattr(m.layout, "dim", []))),
        ("layout.dim", "wrong label", layout(lambda m: setattr(m.layout.dim[1], "label", "t"))),
        ("layout.dim", "huge", layout(lambda m: setattr(m.layout.dim[0], "size", 2**32 - 1))),
        (
            "layout.data_offset",
            "huge",
            layout(lambda m: setattr(m.layout, "data_offset", 2**32 - 1)),
        ),
    ]
    return [
        *(Stray(TELEMETRY, *fault) for fault in faults),
        Stray(TELEMETRY, "all", "twice", lambda genuine, _: genuine),
        _second_source(TELEMETRY, column(0, lambda t: t - 2.0), count=3),
    ]


def _progress() -> list[Stray]:
    return [
        Stray(PROGRESS, "source", "empty", _changed(lambda m, _: setattr(m, "source", ""))),
        Stray(PROGRESS, "source", "wrong", _changed(lambda m, _: setattr(m, "source", "x" * 999))),
        *(Stray(PROGRESS, "stamp", *fault) for fault in _times(lambda m: (m.header, "stamp"))),
        *(Stray(PROGRESS, "time_ref", *fault) for fault in _times(lambda m: (m, "time_ref"))),
        Stray(PROGRESS, "all", "twice", lambda genuine, _: genuine),
    ]


def _clock() -> list[Stray]:
    return [
        *(Stray(CLOCK, "clock", *fault) for fault in _times(lambda m: (m, "clock"))),
        Stray(CLOCK, "all", "twice", lambda genuine, _: genuine),
    ]


def _parameter_event(value: ParameterValue, node: str = "/controller") -> Callable[..., Any]:
    changed = [Parameter(name=DEAD_ZONE_PARAMETER, value=value)]
    return lambda *_: ParameterEvent(node=node, changed_parameters=changed)


def _others() -> list[Stray]:
    def number(value: float) -> ParameterValue:
        return ParameterValue(type=3, double_value=value)

    unreal = sample_message(np.full((1, 7), 1e300), ["x"] * 7)
    alarm = DiagnosticArray(status=[DiagnosticStatus(level=b"\2", name="/plant", message="fire")])
    return [
        Stray(TRUTH, "all", "wrong", lambda *_: unreal),
        Stray(DIAGNOSTICS, "all", "wrong", lambda *_: alarm),
        Stray(PARAMETER_EVENTS, "value", "NaN", _parameter_event(number(math.nan))),
        Stray(PARAMETER_EVENTS, "value", "huge", _parameter_event(number(1e300))),
        Stray(PARAMETER_EVENTS, "value", "negative", _parameter_event(number(-1.0))),
        Stray(PARAMETER_EVENTS, "value", "wrong type", _parameter_event(ParameterValue(type=4))),
        Stray(PARAMETER_EVENTS, "node", "wrong", _parameter_event(number(0.5), "/somebody")),
        Stray(PARAMETER_EVENTS, "node", "empty", _parameter_event(number(0.5), "")),
    ]


STRAYS = [
    *_joint_state(MEASUREMENT, "position", 0.1, lambda now: now + 5 * PERIOD),
    _second_source(MEASUREMENT, _changed(_competing_reading)),
    *map(_stranger, _joint_state(COMMAND, "effort", 100.0, lambda now: now)),
    _second_source(COMMAND, _changed(_competing_command)),
    *_joint_state(BACKLASH_ESTIMATE, "position", 1e3, lambda now: now),
    *_telemetry(),
    *_progress(),
    *_clock(),
    *_others(),
]
"""All strays for a loop that follows its own reference."""

REFERENCE_STRAYS = _joint_state(REFERENCE, "position", 0.1, lambda now: now)
"""Strays for a loop whose reference comes from somebody else."""

SECOND_REFERENCE = Stray(REFERENCE, "all", "from a second source", _changed(_reversed_reference))
"""What a controller cannot tell from the reference that is meant."""
