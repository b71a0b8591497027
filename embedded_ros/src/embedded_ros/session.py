"""The DDS side of a context: one participant and what its nodes share."""

import atexit
import itertools
import threading
import weakref
from typing import Protocol

from cyclonedds.pub import Publisher
from cyclonedds.sub import Subscriber

from embedded_ros import best_available, cyclone
from embedded_ros.dds_qos import may_block, profile_of, to_dds
from embedded_ros.definitions import type_hash
from embedded_ros.domain import close_participant, create_participant
from embedded_ros.endpoints import Reader, Writer
from embedded_ros.errors import RCLError
from embedded_ros.graph import Graph
from embedded_ros.qos_profile import QoSProfile

__all__ = ["Interruptible", "Session"]


class Interruptible(Protocol):
    """Something that blocks and must return when the context is shut down or a signal comes."""

    def interrupt(self) -> None:
        """Return from the wait; safe from any thread."""
        ...


class Session:
    """One participant in a domain.

    Parameters
    ----------
    domain_id : int
    enclave : str

    Attributes
    ----------
    valid : bool
        False once the context is shut down. Entities live on until they are destroyed.
    """

    def __init__(self, domain_id: int, enclave: str) -> None:
        self.domain_id = domain_id
        self.valid = True
        self.participant = create_participant(domain_id, enclave)
        self.ref: int = self.participant._ref
        self.guid = cyclone.guid(self.ref)
        self.publisher = Publisher(self.participant)
        self.subscriber = Subscriber(self.participant)
        self.graph = Graph(self.participant, self.publisher, self.subscriber)
        _sessions.add(self)
        # Reentrant: a garbage collection under the lock may drop a node, which then leaves.
        self._lock = threading.RLock()
        self._closed = False
        self._users = 0
        self._service_ids = itertools.count(1)
        self._interruptibles: weakref.WeakSet[Interruptible] = weakref.WeakSet()

    def writer(self, topic: str, ros_type: str, profile: QoSProfile, extra: str = "") -> Writer:
        """Create a writer; `extra` goes before the type hash in its user data."""
        self._check_valid("publisher")
        profile = self._settled(topic, profile, is_writer=True)
        qos = to_dds(profile, f"{extra}typehash={type_hash(ros_type)};")
        return Writer(
            self.participant, self.publisher, topic, ros_type, qos, may_block=may_block(profile)
        )

    def reader(self, topic: str, ros_type: str, profile: QoSProfile, extra: str = "") -> Reader:
        """Create a reader; `extra` goes before the type hash in its user data."""
        self._check_valid("subscription")
        profile = self._settled(topic, profile, is_writer=False)
        qos = to_dds(profile, f"{extra}typehash={type_hash(ros_type)};")
        return Reader(self.participant, self.subscriber, topic, ros_type, qos)

    def _settled(self, topic: str, profile: QoSProfile, *, is_writer: bool) -> QoSProfile:
        """Give policies that are best available the values that suit the peers."""
        if not best_available.is_open(profile):
            return profile
        if topic.startswith(("rq/", "rr/")):
            return best_available.for_service(profile)
        peers = (
            self.graph.readers(with_qos=True) if is_writer else self.graph.writers(with_qos=True)
        )
        known = [profile_of(peer.qos) for peer in peers if peer.topic == topic and peer.qos]
        settle = best_available.for_publisher if is_writer else best_available.for_subscription
        return settle(profile, known)

    def _check_valid(self, what: str) -> None:
        if not self.valid:
            raise RCLError(f"Failed to create {what}: rcl node's context is invalid")

    def new_service_id(self) -> str:
        """Identifier of a client or service: joins its reader and its writer in discovery."""
        number = next(self._service_ids).to_bytes(4, "big")
        return ".".join(f"{byte:x}" for byte in self.guid[:12] + number)

    def register(self, waiter: Interruptible) -> None:
        """Have a blocking object interrupted; it is forgotten when it is dropped."""
        with self._lock:
            self._interruptibles.add(waiter)

    def interrupt(self) -> None:
        """Interrupt everything that blocks."""
        with self._lock:
            waiters = list(self._interruptibles)
        for waiter in waiters:
            waiter.interrupt()

    def invalidate(self) -> None:
        """Mark the context as shut down and interrupt everything that blocks."""
        self.valid = False
        self.interrupt()

    def acquire(self) -> None:
        """Keep the participant open for a node or an executor."""
        with self._lock:
            self._users += 1

    def release(self) -> None:
        """Undo :meth:`acquire`; the last one after a shutdown closes the participant."""
        with self._lock:
            self._users -= 1
        self.close_if_unused()

    def close_if_unused(self) -> None:
        """Close the participant if the context is shut down and nobody uses it."""
        with self._lock:
            if self.valid or self._users > 0 or self._closed:
                return
            self._closed = True
        self.close()

    def close(self) -> None:
        """Delete the participant and everything in it."""
        _sessions.discard(self)
        self._closed = True
        self.valid = False
        self.graph.close()
        close_participant(self.domain_id, self.ref)


_sessions: weakref.WeakSet[Session] = weakref.WeakSet()


@atexit.register
def _leave_graphs() -> None:
    """Have the peers know at once what a program leaves behind that ends without cleaning up."""
    for session in list(_sessions):
        session.graph.leave()
