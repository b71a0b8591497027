"""The ROS graph: which nodes there are and which DDS endpoints belong to them.

DDS discovery knows endpoints and participants. Which node an endpoint belongs to is told by the
topic ``ros_discovery_info``, where every participant keeps one message with its nodes, the same
that rmw_cyclonedds and rmw_fastrtps write and read.
"""

import threading
from dataclasses import dataclass, field

from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import Publisher
from cyclonedds.sub import Subscriber

from embedded_ros import cyclone
from embedded_ros.cdr import ENCAPSULATION, CdrError, codec
from embedded_ros.dds_qos import to_dds
from embedded_ros.definitions import type_hash
from embedded_ros.discovery import Discovery, Endpoint
from embedded_ros.endpoints import Reader, Writer
from embedded_ros.message_classes import message_class
from embedded_ros.qos_policies import DurabilityPolicy, HistoryPolicy
from embedded_ros.qos_profile import QoSProfile

__all__ = ["Graph", "NodeEntities", "ros_name", "service_name"]

_INFO = "rmw_dds_common/msg/ParticipantEntitiesInfo"
_TOPIC = "ros_discovery_info"

#: Node names of endpoints that no node claims, as rmw gives them.
UNKNOWN_NODE = ("_NODE_NAME_UNKNOWN_", "_NODE_NAMESPACE_UNKNOWN_")
BARE_DDS_NODE = ("_CREATED_BY_BARE_DDS_APP_", "_CREATED_BY_BARE_DDS_APP_")


@dataclass(frozen=True)
class NodeEntities:
    """A node and the GUIDs of its endpoints."""

    name: str
    namespace: str
    readers: set[bytes] = field(default_factory=set)
    writers: set[bytes] = field(default_factory=set)


def ros_name(dds_topic: str) -> str | None:
    """``rt/chatter`` to ``/chatter``; None if this is no ROS topic."""
    return dds_topic[2:] if dds_topic.startswith("rt/") else None


def service_name(dds_topic: str) -> str | None:
    """``rq/addRequest`` and ``rr/addReply`` to ``/add``; None if this is no service."""
    for prefix, suffix in (("rq/", "Request"), ("rr/", "Reply")):
        if dds_topic.startswith(prefix) and dds_topic.endswith(suffix):
            return dds_topic[2 : -len(suffix)]
    return None


class Graph:
    """What one participant tells of its nodes, and what it knows of all."""

    def __init__(
        self, participant: DomainParticipant, publisher: Publisher, subscriber: Subscriber
    ) -> None:
        self._discovery = Discovery(participant)
        self._guid = cyclone.guid(participant._ref)
        # Reentrant: a garbage collection under the lock may drop a node, which then leaves.
        self._lock = threading.RLock()
        self._own: list[NodeEntities] = []
        self._others: dict[bytes, list[NodeEntities]] = {}
        self._seen: set[bytes] = set()
        profile = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        # All participants share the one instance of this topic, so a reader must keep everything.
        keep_all = QoSProfile(
            history=HistoryPolicy.KEEP_ALL, durability=DurabilityPolicy.TRANSIENT_LOCAL
        )
        user_data = f"typehash={type_hash(_INFO)};"
        self._writer = Writer(participant, publisher, _TOPIC, _INFO, to_dds(profile, user_data))
        self._reader = Reader(participant, subscriber, _TOPIC, _INFO, to_dds(keep_all, user_data))

    def add_node(self, name: str, namespace: str) -> NodeEntities:
        """Enter a node of this participant."""
        node = NodeEntities(name, namespace)
        with self._lock:
            self._own.append(node)
            self._publish()
        return node

    def remove_node(self, node: NodeEntities) -> None:
        """Remove a node of this participant."""
        with self._lock:
            self._own = [other for other in self._own if other is not node]
            self._publish()

    def add(
        self, node: NodeEntities, *, writers: tuple[bytes, ...], readers: tuple[bytes, ...]
    ) -> None:
        """Enter endpoints of a node."""
        with self._lock:
            node.writers.update(writers)
            node.readers.update(readers)
            self._publish()

    def remove(
        self, node: NodeEntities, *, writers: tuple[bytes, ...], readers: tuple[bytes, ...]
    ) -> None:
        """Remove endpoints of a node."""
        with self._lock:
            node.writers.difference_update(writers)
            node.readers.difference_update(readers)
            self._publish()

    def _publish(self) -> None:
        self._take_news()  # now and then, so that nothing piles up in a process that never asks
        gid = message_class("rmw_dds_common/msg/Gid")
        node_info = message_class("rmw_dds_common/msg/NodeEntitiesInfo")
        info = message_class(_INFO)(
            gid=gid(data=list(self._guid)),
            node_entities_info_seq=[
                node_info(
                    node_namespace=node.namespace,
                    node_name=node.name,
                    reader_gid_seq=[gid(data=list(guid)) for guid in sorted(node.readers)],
                    writer_gid_seq=[gid(data=list(guid)) for guid in sorted(node.writers)],
                )
                for node in self._own
            ],
        )
        buffer = bytearray(ENCAPSULATION)
        codec(_INFO).write(info, buffer)
        if not self._writer.closed:
            self._writer.write(buffer)

    def _take_news(self) -> None:
        read = codec(_INFO).read
        while (sample := self._reader.take()) is not None:
            try:
                info = read(sample[0], len(ENCAPSULATION))
            except CdrError:
                continue  # a participant of another ROS version
            self._others[info.gid.data.tobytes()] = [
                NodeEntities(
                    node.node_name,
                    node.node_namespace,
                    {gid.data.tobytes() for gid in node.reader_gid_seq},
                    {gid.data.tobytes() for gid in node.writer_gid_seq},
                )
                for node in info.node_entities_info_seq
            ]

    def nodes(self) -> list[NodeEntities]:
        """Nodes of all participants that are alive, own ones first."""
        alive = self._discovery.participants()
        with self._lock:
            self._take_news()
            self._others.pop(self._guid, None)
            for guid in [guid for guid in self._others if guid not in alive]:
                # Forgetting it at once would lose one whose discovery is still under way.
                if guid in self._seen:
                    del self._others[guid]
            self._seen.update(alive)
            self._seen &= alive | self._others.keys()
            return [
                *self._own,
                *(node for guid, nodes in self._others.items() if guid in alive for node in nodes),
            ]

    def node_of(self, endpoint: Endpoint) -> tuple[str, str]:
        """Name and namespace of the node to which an endpoint belongs."""
        for node in self.nodes():
            if endpoint.guid in node.readers or endpoint.guid in node.writers:
                return node.name, node.namespace
        with self._lock:
            is_ros = endpoint.participant in self._others or endpoint.participant == self._guid
        return UNKNOWN_NODE if is_ros else BARE_DDS_NODE

    def writers(self, *, with_qos: bool = False) -> list[Endpoint]:
        """All writers in the domain."""
        return self._discovery.writers(with_qos=with_qos)

    def readers(self, *, with_qos: bool = False) -> list[Endpoint]:
        """All readers in the domain."""
        return self._discovery.readers(with_qos=with_qos)

    def leave(self) -> None:
        """Tell the others that the nodes are gone; their endpoints live on."""
        with self._lock:
            self._own = []
            self._publish()

    def close(self) -> None:
        """Delete the endpoints of the graph itself."""
        self._writer.close()
        self._reader.close()
