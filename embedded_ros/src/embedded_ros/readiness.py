"""What an executor waits for: the part of :class:`rclpy.executors.Executor` with the wait set."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, cast

from embedded_ros import cyclone
from embedded_ros.endpoint_events import EndpointEvents
from rclpy.client import Client
from rclpy.guard_condition import GuardCondition
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.task import Task
from rclpy.timer import Timer

if TYPE_CHECKING:
    from embedded_ros.session import Session
    from rclpy.executors import Executor
    from rclpy.node import Node
    from rclpy.publisher import Publisher

__all__ = ["Entity", "Readiness", "Work"]

Watched = EndpointEvents | Subscription | GuardCondition | Client | Service
Entity = Timer | Watched
Work = Task | tuple[Entity, Any]

# rclpy serves the entities of a node in this order.
_ORDER: dict[type, int] = {
    EndpointEvents: 0,
    Timer: 1,
    Subscription: 2,
    GuardCondition: 3,
    Client: 4,
    Service: 5,
}


class Readiness:
    """Knows the entities of the nodes and finds out which are ready."""

    def _init_readiness(self, session: Session) -> None:
        self._nodes: list[Node] = []
        self._nodes_lock = threading.RLock()
        self._is_shutdown = False
        self._guard = cyclone.GuardCondition(session.ref)
        self._wait_set = cyclone.WaitSet(session.ref)
        self._wait_set.attach(self._guard.ref)
        # What the wait set watches, by the number that it reports.
        self._attached: dict[int, Watched] = {}
        self._timers: list[Timer] = []
        self._entities_changed = True
        # Entities or timers that are due while another callback of their group runs. They are not
        # watched meanwhile: they would wake the wait set again and again.
        self._has_blocked = False
        self._ready: deque[Entity] = deque()
        self._tasks: deque[Task] = deque()
        # Coroutines that yielded without waiting for anything: they go on after a look around.
        self._yielded: deque[Task] = deque()

    def get_nodes(self) -> list[Node]:
        """Nodes whose callbacks are run."""
        with self._nodes_lock:
            return list(self._nodes)

    def add_node(self, node: Node) -> bool:
        """Run the callbacks of a node; False if that is done already."""
        with self._nodes_lock:
            if node in self._nodes:
                return False
            self._nodes.append(node)
        node.executor = cast("Executor", self)
        self.wake()
        return True

    def remove_node(self, node: Node) -> None:
        """Run the callbacks of a node no more."""
        with self._nodes_lock:
            if node not in self._nodes:
                return
            self._nodes.remove(node)
        self.wake()

    def interrupt(self) -> None:
        """Come out of the wait to see whether the context is shut down."""
        self._guard.set()

    def wake(self) -> None:
        """Look at the nodes again: an entity was made or destroyed."""
        self._entities_changed = True
        self._guard.set()

    def _shortened(self, left: int) -> int:
        """Time to wait: up to `left`, not beyond the next timer."""
        if self._yielded or self._tasks or self._entities_changed:
            return 0
        for timer in self._timers:
            until = timer._due_in()
            if until is None or until >= left:
                continue
            group = timer.callback_group
            if until == 0 and group is not None and not group.can_execute(timer):
                self._has_blocked = True
                if not group.can_execute(timer):
                    continue
            left = until
        return max(left, 0)

    def _note_ready(self, fired: list[int], *, timers_too: bool) -> None:
        ready: list[Entity] = []
        # A timer that came due while something else ended the wait makes the next one short.
        if timers_too:
            ready += [timer for timer in self._timers if timer._due_in() == 0]
        ready += [self._attached[ref] for ref in fired if ref in self._attached]
        if len(ready) > 1:
            ready.sort(key=lambda entity: _ORDER[type(entity)])
        self._ready.extend(ready)

    def _update_wait_set(self) -> None:
        self._entities_changed = False
        # Up while we look: who releases a group meanwhile must wake us to look again.
        self._has_blocked = True
        found_blocked = False
        wanted: dict[int, Watched] = {}
        timers: list[Timer] = []
        for node in self.get_nodes():
            timers.extend(node.timers)
            watched: tuple[Watched, ...] = (
                *_events_of(node),
                *node.subscriptions,
                *node.guards,
                *node.clients,
                *node.services,
            )
            for entity in watched:
                group = entity.callback_group
                if group is None or group.can_execute(entity):
                    wanted[entity._wait_ref] = entity
                else:
                    found_blocked = True
        self._has_blocked = found_blocked
        with self._nodes_lock:
            if self._is_shutdown:
                return
            for ref in self._attached.keys() - wanted.keys():
                self._wait_set.detach(ref)
            for ref in wanted.keys() - self._attached.keys():
                self._wait_set.attach(ref)
            self._attached = wanted
            self._timers = timers
        known = {*map(id, wanted.values()), *map(id, timers)}
        for gone in [entity for entity in self._ready if id(entity) not in known]:
            self._ready.remove(gone)


def _events_of(node: Node) -> Iterator[EndpointEvents]:
    endpoints: tuple[Publisher | Subscription, ...] = (*node.publishers, *node.subscriptions)
    for endpoint in endpoints:
        if endpoint._events is not None:
            yield endpoint._events
