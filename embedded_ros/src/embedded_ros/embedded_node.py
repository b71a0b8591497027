"""What is below a node: its names, its entities and who is told of them."""

import weakref
from collections.abc import Callable
from typing import Any, Protocol, Self

from embedded_ros.endpoints import Reader, Writer
from embedded_ros.entity_registry import EntityRegistry, Kind
from embedded_ros.errors import InvalidHandle
from embedded_ros.node_names import NodeNames
from embedded_ros.node_presence import NodePresence
from embedded_ros.session import Session

__all__ = ["EmbeddedNode"]


class _Membership(Protocol):
    """A callback group, as far as it gets members."""

    def add_entity(self, entity: Any) -> None:
        """Put an entity into the group."""
        ...


class EmbeddedNode:
    """The one object that a node keeps for all of this.

    A node is there to be subclassed: every other attribute could be one of the subclass, too.

    Parameters
    ----------
    session : Session
    names : NodeNames
    on_change : callable
        Called when there is an entity more or less.

    Attributes
    ----------
    registry : EntityRegistry
    presence : NodePresence
        What the network knows of the node.
    """

    def __init__(self, session: Session, names: NodeNames, on_change: Callable[[], None]) -> None:
        self._session = session
        self._names = names
        self._is_over = False
        self.on_change = on_change
        self.registry = EntityRegistry()
        self.presence = NodePresence(session, names.name, names.namespace)

    def _usable(self) -> Self:
        if self._is_over:
            raise InvalidHandle
        return self

    @property
    def session(self) -> Session:
        """The participant; ``InvalidHandle`` once the node is destroyed."""
        return self._usable()._session

    @property
    def names(self) -> NodeNames:
        """Names of the node; ``InvalidHandle`` once it is destroyed."""
        return self._usable()._names

    def leave_with(self, node: object) -> Callable[[], Any]:
        """Have the network forget the node when its object is dropped, or when this is called."""
        leave = weakref.finalize(node, self.presence.end)
        leave.atexit = False  # threads may still use its entities
        return leave

    def add(self, kind: Kind, entity: Any, group: _Membership | None = None) -> None:
        """Enter an entity and its endpoints."""
        if group is not None:
            group.add_entity(entity)
        self.registry.add(kind, entity)
        endpoints = _endpoints(entity)
        if endpoints:
            self.presence.enter(*endpoints)
        self.on_change()

    def remove(self, kind: Kind, entity: Any) -> bool:
        """Remove and destroy an entity; False if there is none."""
        if not self.registry.remove(kind, entity):
            return False
        self.registry.remove(Kind.EVENTS, getattr(entity, "_watched_events", None))
        entity.destroy()
        endpoints = _endpoints(entity)
        if endpoints:
            self.presence.leave(*endpoints)
        self.on_change()
        return True

    def destroy_all(self) -> None:
        """Remove and destroy all entities, and be of no use any more."""
        self._is_over = True
        for entity in self.registry.empty():
            entity.destroy()
        self.on_change()


def _endpoints(entity: Any) -> tuple[Writer | Reader, ...]:
    """What an entity has in the network; timers and guard conditions have nothing."""
    endpoints: tuple[Writer | Reader, ...] = getattr(entity, "_endpoints", ())
    return endpoints
