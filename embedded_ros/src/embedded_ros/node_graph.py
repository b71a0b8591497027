"""What a node knows of the graph: the part of :class:`rclpy.node.Node` that asks for it."""

import time
from collections.abc import Callable, Iterable

from embedded_ros.dds_qos import profile_of
from embedded_ros.deadline import Deadline
from embedded_ros.discovery import Endpoint
from embedded_ros.embedded_node import EmbeddedNode
from embedded_ros.endpoint_info import TopicEndpointInfo, TopicEndpointTypeEnum, TypeHash
from embedded_ros.errors import (
    InvalidServiceNameException,
    InvalidTopicNameException,
    NodeNameNonExistentError,
)
from embedded_ros.graph import NodeEntities, ros_name, service_name
from embedded_ros.names import expand, full_topic_name_error, join

__all__ = ["NodeGraph"]

NamesAndTypes = list[tuple[str, list[str]]]
_POLL_S = 0.1


class NodeGraph:
    """Queries of the graph."""

    _embedded: EmbeddedNode

    def get_name(self) -> str:
        """Name of the node."""
        raise NotImplementedError

    def get_namespace(self) -> str:
        """Namespace of the node."""
        raise NotImplementedError

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """Expand and remap a topic name."""
        raise NotImplementedError

    # -------------------------------------------------------------------- nodes

    def get_node_names(self) -> list[str]:
        """Names of all nodes."""
        return [node.name for node in self._embedded.session.graph.nodes()]

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        """Names and namespaces of all nodes."""
        return [(node.name, node.namespace) for node in self._embedded.session.graph.nodes()]

    def get_node_names_and_namespaces_with_enclaves(self) -> list[tuple[str, str, str]]:
        """Names, namespaces and security enclaves of all nodes; without security ``/``."""
        return [(node.name, node.namespace, "/") for node in self._embedded.session.graph.nodes()]

    def get_fully_qualified_node_names(self) -> list[str]:
        """Namespaces and names of all nodes, joined."""
        return [join(node.namespace, node.name) for node in self._embedded.session.graph.nodes()]

    def wait_for_node(self, fully_qualified_node_name: str, timeout: float) -> bool:
        """Wait for a node; tell whether it is there."""
        wanted = f"/{fully_qualified_node_name.lstrip('/')}"
        deadline = Deadline(max(0.0, timeout))
        # Discovery of nodes has no event of its own to wait for; rclpy polls as well.
        while not (is_there := wanted in self.get_fully_qualified_node_names()):
            if deadline.is_over():
                break
            time.sleep(min(_POLL_S, deadline.nanoseconds_left() / 1e9))
        return is_there

    # ---------------------------------------------------------- topics, services

    def get_topic_names_and_types(self, no_demangle: bool = False) -> NamesAndTypes:
        """All topics and their types."""
        graph = self._embedded.session.graph
        return _names_and_types([*graph.writers(), *graph.readers()], _topic_namer(no_demangle))

    def get_service_names_and_types(self) -> NamesAndTypes:
        """All services and their types."""
        graph = self._embedded.session.graph
        return _names_and_types([*graph.writers(), *graph.readers()], service_name)

    def get_publisher_names_and_types_by_node(
        self, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> NamesAndTypes:
        """Topics that a node publishes, and their types."""
        node = self.__find_node(node_name, node_namespace)
        own = _of(self._embedded.session.graph.writers(), node.writers)
        return _names_and_types(own, _topic_namer(no_demangle))

    def get_subscriber_names_and_types_by_node(
        self, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> NamesAndTypes:
        """Topics to which a node subscribes, and their types."""
        node = self.__find_node(node_name, node_namespace)
        own = _of(self._embedded.session.graph.readers(), node.readers)
        return _names_and_types(own, _topic_namer(no_demangle))

    def get_service_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> NamesAndTypes:
        """Services that a node offers, and their types."""
        node = self.__find_node(node_name, node_namespace)
        requests = [
            endpoint
            for endpoint in _of(self._embedded.session.graph.readers(), node.readers)
            if endpoint.topic.startswith("rq/")
        ]
        return _names_and_types(requests, service_name)

    def get_client_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> NamesAndTypes:
        """Services that a node calls, and their types."""
        node = self.__find_node(node_name, node_namespace)
        replies = [
            endpoint
            for endpoint in _of(self._embedded.session.graph.readers(), node.readers)
            if endpoint.topic.startswith("rr/")
        ]
        return _names_and_types(replies, service_name)

    def __find_node(self, name: str, namespace: str) -> NodeEntities:
        for node in self._embedded.session.graph.nodes():
            if (node.name, node.namespace) == (name, namespace):
                return node
        raise NodeNameNonExistentError(
            f"Cannot get information about a node that is not there: '{join(namespace, name)}'"
        )

    # ----------------------------------------------------------------- counting

    def count_publishers(self, topic_name: str) -> int:
        """Number of publishers of a topic."""
        dds_topic = f"rt{self.__full_name(topic_name)}"
        return _count(self._embedded.session.graph.writers(), dds_topic)

    def count_subscribers(self, topic_name: str) -> int:
        """Number of subscriptions to a topic."""
        dds_topic = f"rt{self.__full_name(topic_name)}"
        return _count(self._embedded.session.graph.readers(), dds_topic)

    def count_clients(self, service_name: str) -> int:
        """Number of clients of a service."""
        dds_topic = f"rr{self.__full_name(service_name, is_service=True)}Reply"
        return _count(self._embedded.session.graph.readers(), dds_topic)

    def count_services(self, service_name: str) -> int:
        """Number of servers of a service."""
        dds_topic = f"rq{self.__full_name(service_name, is_service=True)}Request"
        return _count(self._embedded.session.graph.readers(), dds_topic)

    def __full_name(self, name: str, *, is_service: bool = False) -> str:
        full_name = expand(name, self.get_name(), self.get_namespace())
        fault = full_topic_name_error(full_name)
        if fault is not None:
            invalid = InvalidServiceNameException if is_service else InvalidTopicNameException
            raise invalid(full_name, *fault)
        return full_name

    # ---------------------------------------------------------------- endpoints

    def get_publishers_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        """Publishers of a topic; with `no_mangle` it is the name of a DDS topic."""
        endpoints = self._embedded.session.graph.writers(with_qos=True)
        return self.__infos(endpoints, topic_name, no_mangle, TopicEndpointTypeEnum.PUBLISHER)

    def get_subscriptions_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        """Subscriptions to a topic; with `no_mangle` it is the name of a DDS topic."""
        endpoints = self._embedded.session.graph.readers(with_qos=True)
        return self.__infos(endpoints, topic_name, no_mangle, TopicEndpointTypeEnum.SUBSCRIPTION)

    def __infos(
        self,
        endpoints: Iterable[Endpoint],
        topic_name: str,
        no_mangle: bool,
        kind: TopicEndpointTypeEnum,
    ) -> list[TopicEndpointInfo]:
        if no_mangle:
            dds_topic = topic_name
        else:
            self.__full_name(topic_name)
            dds_topic = f"rt{self.resolve_topic_name(topic_name)}"
        infos = []
        for endpoint in endpoints:
            if endpoint.topic != dds_topic or endpoint.qos is None:
                continue
            name, namespace = self._embedded.session.graph.node_of(endpoint)
            infos.append(
                TopicEndpointInfo(
                    node_name=name,
                    node_namespace=namespace,
                    topic_type=endpoint.dds_type if no_mangle else endpoint.type_name,
                    topic_type_hash=_type_hash(endpoint),
                    endpoint_type=kind,
                    endpoint_gid=list(endpoint.guid),
                    qos_profile=profile_of(endpoint.qos),
                )
            )
        return infos


def _topic_namer(no_demangle: bool) -> Callable[[str], str | None]:
    return str if no_demangle else ros_name


def _of(endpoints: Iterable[Endpoint], guids: set[bytes]) -> list[Endpoint]:
    return [endpoint for endpoint in endpoints if endpoint.guid in guids]


def _count(endpoints: Iterable[Endpoint], dds_topic: str) -> int:
    return sum(endpoint.topic == dds_topic for endpoint in endpoints)


def _names_and_types(
    endpoints: Iterable[Endpoint], name_of: Callable[[str], str | None]
) -> NamesAndTypes:
    found: dict[str, set[str]] = {}
    for endpoint in endpoints:
        name = name_of(endpoint.topic)
        if name is not None:
            # Names that are not translated go with types that are not.
            type_name = endpoint.dds_type if name_of is str else endpoint.type_name
            if name_of is service_name:
                type_name = type_name.removesuffix("_Request").removesuffix("_Response")
            found.setdefault(name, set()).add(type_name)
    return sorted((name, sorted(types)) for name, types in found.items())


def _type_hash(endpoint: Endpoint) -> TypeHash:
    from cyclonedds.core import Policy

    if endpoint.qos is not None and Policy.Userdata in endpoint.qos:
        for item in endpoint.qos[Policy.Userdata].data.decode(errors="replace").split(";"):
            key, _, value = item.partition("=RIHS01_")
            if key == "typehash" and len(value) == 64:
                return TypeHash(1, bytes.fromhex(value))
    return TypeHash()
