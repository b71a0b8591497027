"""DDS writers and readers that carry CDR payloads of ROS types."""

from collections.abc import Callable
from functools import cache
from typing import Any, Self, TypeVar

import cyclonedds.idl.types as idl_types
from cyclonedds.core import DDSException, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct, make_idl_struct
from cyclonedds.pub import DataWriter, Publisher
from cyclonedds.sub import DataReader, Subscriber
from cyclonedds.topic import Topic

from embedded_ros import cyclone
from embedded_ros.cdr import CdrError
from embedded_ros.errors import InvalidHandle, RCLError
from embedded_ros.own_warnings import Complaints

__all__ = ["Reader", "Writer", "dds_type_name", "ros_type_of"]

_T = TypeVar("_T")


def dds_type_name(ros_type: str) -> str:
    """``std_msgs/msg/Float64`` to ``std_msgs::msg::dds_::Float64_``."""
    package, kind, name = ros_type.split("/")
    return f"{package}::{kind}::dds_::{name}_"


def ros_type_of(dds_type: str) -> str:
    """``std_msgs::msg::dds_::Float64_`` to ``std_msgs/msg/Float64``; others as they are."""
    parts = dds_type.split("::")
    if len(parts) == 4 and parts[2] == "dds_" and parts[3].endswith("_"):
        return f"{parts[0]}/{parts[1]}/{parts[3][:-1]}"
    return dds_type


@cache
def _carrier(ros_type: str) -> type[IdlStruct]:
    """A DDS type of the right name that lets any payload pass.

    Cyclone checks a sample only as far as the type goes and keeps all of it, so one octet is
    enough, and it takes 1 ms where the true type may take 50. The member bears the name of the ROS
    type because two embedded endpoints are matched by structure, no longer by type name. It is a
    ``byte``: other octet types crash Cyclone 0.10 peers.
    """
    name = ros_type.rpartition("/")[2]
    members = {ros_type.replace("/", "__"): idl_types.byte}
    return make_idl_struct(f"{name}_", dds_type_name(ros_type), members)


class _Endpoint:
    """What writers and readers share: a topic and an entity, deleted explicitly and once."""

    def __init__(self, topic: "Topic[Any]", entity: "DataWriter[Any] | DataReader[Any]") -> None:
        # Kept alive for the binding, which deletes what is dropped.
        self._topic = topic
        self._entity = entity
        self.ref: int = entity._ref
        self.guid = cyclone.guid(self.ref)
        self.closed = False

    def usable(self) -> Self:
        """Return this; ``InvalidHandle`` once it is closed."""
        if self.closed:
            raise InvalidHandle
        return self

    def close(self) -> None:
        """Delete the entity. Again is fine."""
        if not self.closed:
            self.closed = True
            cyclone.delete(self.ref)
            cyclone.delete(self._topic._ref)


class Writer(_Endpoint):
    """Writes payloads to a topic.

    Parameters
    ----------
    participant : DomainParticipant
    publisher : cyclonedds.pub.Publisher
    topic_name : str
        DDS name, ``rt/chatter``.
    ros_type : str
    qos : cyclonedds.core.Qos
    may_block : bool
        Whether a write can wait for slow readers (reliable and keep-all).
    """

    def __init__(
        self,
        participant: DomainParticipant,
        publisher: Publisher,
        topic_name: str,
        ros_type: str,
        qos: Qos,
        *,
        may_block: bool = False,
    ) -> None:
        try:
            topic = Topic(participant, topic_name, _carrier(ros_type))
            super().__init__(topic, DataWriter(publisher, topic, qos=qos))
        except DDSException as error:
            raise RCLError(f"no writer of {ros_type} on {topic_name}: {error}") from error
        self._write = cyclone.write_blocking if may_block else cyclone.write

    def write(self, payload: bytes | bytearray) -> None:
        """Write a payload that begins with its encapsulation header."""
        self._write(self.ref, bytes(payload) + b"\0" * (-len(payload) % 4))

    def matched_readers(self) -> list[int]:
        """Instance handles of the matched readers."""
        return cyclone.matched(self.ref, writers=False)


class Reader(_Endpoint):
    """Takes payloads from a topic; `condition` holds while there is one."""

    def __init__(
        self,
        participant: DomainParticipant,
        subscriber: Subscriber,
        topic_name: str,
        ros_type: str,
        qos: Qos,
    ) -> None:
        try:
            topic = Topic(participant, topic_name, _carrier(ros_type))
            super().__init__(topic, DataReader(subscriber, topic, qos=qos))
        except DDSException as error:
            raise RCLError(f"no reader of {ros_type} on {topic_name}: {error}") from error
        self.condition = cyclone.read_condition(self.ref)
        self._topic_name = topic_name
        self._complaints = Complaints()

    def take(self) -> tuple[bytes, Any] | None:
        """Oldest payload and its DDS sample info; None if there is none."""
        return cyclone.take_one(self.ref)

    def take_decoded(self, decode: Callable[[bytes], _T]) -> tuple[_T, Any] | None:
        """Oldest sample, its payload decoded, and its DDS sample info; None if there is none.

        Anybody may write to a topic and no node must die of it: what `decode` refuses with
        :class:`CdrError` is dropped with a warning, at most one a second.
        """
        sample = self.take()
        if sample is None:
            return None
        try:
            return decode(sample[0]), sample[1]
        except CdrError as error:
            self._complaints.add(f"what came on {self._topic_name} is dropped: {error}")
            return None

    def matched_writers(self) -> list[int]:
        """Instance handles of the matched writers."""
        return cyclone.matched(self.ref, writers=True)
