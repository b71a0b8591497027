"""What a node has made: the part of :class:`rclpy.node.Node` that keeps and destroys it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from embedded_ros.endpoints import Reader, Writer
from rclpy.client import Client
from rclpy.guard_condition import GuardCondition
from rclpy.publisher import Publisher
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.timer import Rate, Timer

if TYPE_CHECKING:
    from embedded_ros.graph import NodeEntities
    from embedded_ros.session import Session

__all__ = ["OwnedEntities"]


class OwnedEntities:
    """Publishers, subscriptions, clients, services, timers and guard conditions."""

    _session: Session
    _entities: NodeEntities

    def _init_entities(self) -> None:
        self._publishers: list[Publisher] = []
        self._subscriptions: list[Subscription] = []
        self._clients: list[Client] = []
        self._services: list[Service] = []
        self._timers: list[Timer] = []
        self._guards: list[GuardCondition] = []
        #: What lives in the network; it is closed even if the node is just dropped.
        self._closeables: set[Any] = set()

    def _wake_executor(self) -> None:
        """Have the executor look at the entities again."""
        raise NotImplementedError

    def _enter(self, *endpoints: Writer | Reader) -> None:
        """Show endpoints in the graph."""
        self._closeables.update(endpoints)
        self._session.graph.add(self._entities, **_guids(endpoints))
        self._wake_executor()

    @property
    def publishers(self) -> Iterator[Publisher]:
        """Publishers of the node."""
        return iter(list(self._publishers))

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """Subscriptions of the node."""
        return iter(list(self._subscriptions))

    @property
    def clients(self) -> Iterator[Client]:
        """Service clients of the node."""
        return iter(list(self._clients))

    @property
    def services(self) -> Iterator[Service]:
        """Services of the node."""
        return iter(list(self._services))

    @property
    def timers(self) -> Iterator[Timer]:
        """Timers of the node."""
        return iter(list(self._timers))

    @property
    def guards(self) -> Iterator[GuardCondition]:
        """Guard conditions of the node."""
        return iter(list(self._guards))

    def _entity_types(self) -> set[str]:
        """ROS types of the publishers and subscriptions of the node."""
        types = [publisher.msg_type for publisher in self._publishers]
        types += [subscription.msg_type for subscription in self._subscriptions]
        return {msg_type._ros_type for msg_type in types}

    def destroy_publisher(self, publisher: Publisher) -> bool:
        """Destroy a publisher; False if it is not one of this node."""
        return self._destroy(self._publishers, publisher, publisher._writer)

    def destroy_subscription(self, subscription: Subscription) -> bool:
        """Destroy a subscription; False if it is not one of this node."""
        return self._destroy(self._subscriptions, subscription, subscription._reader)

    def destroy_client(self, client: Client) -> bool:
        """Destroy a client; False if it is not one of this node."""
        ports = client._ports
        return self._destroy(self._clients, client, ports.writer, ports.reader)

    def destroy_service(self, service: Service) -> bool:
        """Destroy a service; False if it is not one of this node."""
        ports = service._ports
        return self._destroy(self._services, service, ports.writer, ports.reader)

    def destroy_timer(self, timer: Timer) -> bool:
        """Destroy a timer; False if it is not one of this node."""
        return self._destroy(self._timers, timer)

    def destroy_guard_condition(self, guard: GuardCondition) -> bool:
        """Destroy a guard condition; False if it is not one of this node."""
        return self._destroy(self._guards, guard)

    def destroy_rate(self, rate: Rate) -> bool:
        """Destroy a rate; False if it is not one of this node."""
        success = self.destroy_timer(rate._ticker)
        rate.destroy()
        return success

    def _destroy(self, entities: list[Any], entity: Any, *endpoints: Writer | Reader) -> bool:
        if entity not in entities:
            return False
        entities.remove(entity)
        entity.destroy()
        if endpoints:
            self._closeables.difference_update(endpoints)
            self._session.graph.remove(self._entities, **_guids(endpoints))
        self._wake_executor()
        return True

    def _destroy_entities(self) -> None:
        for entities in (
            self._publishers,
            self._subscriptions,
            self._clients,
            self._services,
            self._timers,
            self._guards,
        ):
            while entities:
                entities.pop().destroy()


def _guids(endpoints: tuple[Writer | Reader, ...]) -> dict[str, tuple[bytes, ...]]:
    return {
        "writers": tuple(end.guid for end in endpoints if isinstance(end, Writer)),
        "readers": tuple(end.guid for end in endpoints if isinstance(end, Reader)),
    }
