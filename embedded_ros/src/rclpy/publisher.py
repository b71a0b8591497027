"""Publishers."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from embedded_ros import cyclone
from embedded_ros.cdr import ENCAPSULATION, codec
from embedded_ros.endpoints import Writer
from embedded_ros.errors import RCLError
from rclpy.duration import Duration
from rclpy.exceptions import InvalidHandle
from rclpy.qos import QoSProfile

if TYPE_CHECKING:
    from embedded_ros.endpoint_events import EndpointEvents
    from embedded_ros.session import Session

__all__ = ["Publisher"]


class Publisher:
    """Sends messages to a topic; made by :meth:`rclpy.node.Node.create_publisher`."""

    def __init__(
        self,
        session: Session,
        writer: Writer,
        msg_type: type[Any],
        topic: str,
        topic_name: str,
        qos_profile: QoSProfile,
    ) -> None:
        self._session = session
        self._writer = writer
        self._topic_name = topic_name
        #: Callbacks for events, watched by executors; set by the node.
        self._events: EndpointEvents | None = None
        self._serialize: Callable[[Any, bytearray], None] = codec(msg_type._ros_type).write
        self.msg_type = msg_type
        self.topic = topic
        self.qos_profile = qos_profile

    def publish(self, msg: Any) -> None:
        """Send a message.

        Parameters
        ----------
        msg : message or bytes
            Bytes are sent as they are: CDR with its encapsulation header.

        Raises
        ------
        TypeError
            If `msg` is of another type, or a field holds what its type cannot.
        """
        if self._writer.closed:
            raise InvalidHandle
        if isinstance(msg, self.msg_type):
            payload = bytearray(ENCAPSULATION)
            self._serialize(msg, payload)
        elif isinstance(msg, bytes):
            payload = bytearray(msg)
        else:
            raise TypeError(f"Expected {self.msg_type}, got {type(msg)}")
        if not self._session.valid:
            raise RCLError("Failed to publish: publisher's context is invalid")
        self._writer.write(payload)

    def get_subscription_count(self) -> int:
        """Number of matched subscriptions."""
        return len(self._checked().matched_readers())

    @property
    def topic_name(self) -> str:
        """Topic after expansion and remapping."""
        self._checked()
        return self._topic_name

    def assert_liveliness(self) -> None:
        """Tell that the publisher lives, if its liveliness is manual."""
        cyclone.assert_liveliness(self._checked().ref)

    def wait_for_all_acked(self, timeout: Duration | None = None) -> bool:
        """Wait until the reliable subscriptions have acknowledged every message.

        Parameters
        ----------
        timeout : Duration, optional
            Negative, or by default: for ever.

        Returns
        -------
        bool
            False if it did not happen in time.
        """
        nanoseconds = -1 if timeout is None else timeout.nanoseconds
        return cyclone.wait_for_acks(
            self._checked().ref, cyclone.INFINITE if nanoseconds < 0 else nanoseconds
        )

    def _checked(self) -> Writer:
        if self._writer.closed:
            raise InvalidHandle
        return self._writer

    def destroy(self) -> None:
        """Delete the publisher. Again is fine."""
        self._writer.close()
