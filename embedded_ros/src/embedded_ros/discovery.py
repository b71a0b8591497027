"""What DDS discovery knows: the participants, writers and readers in the domain.

Cyclone DDS tells of them in topics of its own. A reader of such a topic is kept and asked for its
news, because one that is made for a single question takes a hundred times as long.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Generic, TypeVar

from cyclonedds._clayer import ddspy_take_endpoint, ddspy_take_participant
from cyclonedds.builtin import (
    BuiltinDataReader,
    BuiltinTopic,
    BuiltinTopicDcpsParticipant,
    BuiltinTopicDcpsPublication,
    BuiltinTopicDcpsSubscription,
)
from cyclonedds.builtin_types import cqos_to_qos
from cyclonedds.core import Qos
from cyclonedds.domain import DomainParticipant

from embedded_ros.endpoints import ros_type_of
from embedded_ros.held_signals import HeldSignals

__all__ = ["Discovery", "Endpoint"]

_ALIVE: Final = 16
_AT_A_TIME: Final = 256

_T = TypeVar("_T")


@dataclass(frozen=True)
class Endpoint:
    """A discovered DDS writer or reader."""

    guid: bytes
    participant: bytes
    topic: str
    dds_type: str
    qos: Qos | None

    @property
    def type_name(self) -> str:
        """ROS type, ``std_msgs/msg/Float64``."""
        return ros_type_of(self.dds_type)


class Discovery:
    """What one participant knows of the domain, itself included."""

    def __init__(self, participant: DomainParticipant) -> None:
        # QoS costs more than all the rest, and few questions are about it.
        self._participants = _Present(participant, BuiltinTopicDcpsParticipant, _take_participants)
        self._endpoints = {
            (topic, with_qos): _Present(participant, topic, take)
            for topic in (BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription)
            for with_qos, take in ((False, _take_endpoints), (True, _take_endpoints_with_qos))
        }

    def participants(self) -> set[bytes]:
        """GUIDs of all participants."""
        return set(self._participants.all())

    def writers(self, *, with_qos: bool = False) -> list[Endpoint]:
        """All writers."""
        return self._endpoints[BuiltinTopicDcpsPublication, with_qos].all()

    def readers(self, *, with_qos: bool = False) -> list[Endpoint]:
        """All readers."""
        return self._endpoints[BuiltinTopicDcpsSubscription, with_qos].all()


class _Present(Generic[_T]):
    """Those of one kind that are there; begins to look when it is asked first."""

    def __init__(
        self,
        participant: DomainParticipant,
        topic: BuiltinTopic,
        take: Callable[[int], "list[tuple[bytes, Any, _T]]"],
    ) -> None:
        self._participant = participant
        self._topic = topic
        self._take = take
        self._reader: BuiltinDataReader | None = None
        self._present: dict[bytes, _T] = {}
        # Reentrant: a garbage collection under the lock may drop what then asks the graph.
        self._lock = threading.RLock()

    def all(self) -> list[_T]:
        with self._lock, HeldSignals():
            if self._reader is None:
                self._reader = BuiltinDataReader(self._participant, self._topic)
            while samples := self._take(self._reader._ref):
                for key, info, item in samples:
                    if info.instance_state == _ALIVE:
                        self._present[key] = item
                    else:
                        self._present.pop(key, None)
            return list(self._present.values())


def _take_participants(reader: int) -> list[tuple[bytes, Any, bytes]]:
    return _samples(ddspy_take_participant(reader, _AT_A_TIME, _participant, _no_qos))


def _take_endpoints(reader: int) -> list[tuple[bytes, Any, Endpoint]]:
    return _samples(ddspy_take_endpoint(reader, _AT_A_TIME, _endpoint, _no_qos))


def _take_endpoints_with_qos(reader: int) -> list[tuple[bytes, Any, Endpoint]]:
    return _samples(ddspy_take_endpoint(reader, _AT_A_TIME, _endpoint, cqos_to_qos))


def _samples(taken: Any) -> list[Any]:
    # A number is an error code: the participant is deleted.
    return taken if isinstance(taken, list) else []


def _no_qos(_pointer: int) -> None:
    """Spare the conversion of QoS that nobody looks at."""


def _participant(key: bytes, _qos: None, info: Any) -> tuple[bytes, Any, bytes]:
    return key, info, key


def _endpoint(
    key: bytes,
    participant: bytes,
    _handle: int,
    topic: str,
    type_name: str,
    qos: Qos | None,
    info: Any,
    _type_id: bytes | None,
) -> tuple[bytes, Any, Endpoint]:
    guid = bytes(key)
    return guid, info, Endpoint(guid, bytes(participant), topic, type_name, qos)
