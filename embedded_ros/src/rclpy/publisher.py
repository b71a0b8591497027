"""Publishers."""

from collections.abc import Callable
from typing import Any

from embedded_ros import cyclone
from embedded_ros.cdr import ENCAPSULATION, codec
from embedded_ros.deadline import FOREVER
from embedded_ros.endpoint_events import EndpointEvents
from embedded_ros.endpoints import Writer
from embedded_ros.errors import InvalidHandle, RCLError
from embedded_ros.session import Session
from rclpy.duration import Duration
from rclpy.qos import QoSProfile

__all__ = ["Publisher"]


class Publisher:
    """Sends messages to a topic; made by :meth:`rclpy.node.Node.create_publisher`.

    Used after :meth:`destroy` it raises :class:`InvalidHandle`.
    """

    def __init__(
        self,
        session: Session,
        writer: Writer,
        msg_type: type[Any],
        topic: str,
        topic_name: str,
        qos_profile: QoSProfile,
    ) -> None:
        self.msg_type = msg_type
        self.topic = topic
        self.qos_profile = qos_profile
        self._session = session
        self._writer = writer
        self._serialize: Callable[[Any, bytearray], None] = codec(msg_type._ros_type).write
        self._full_name = topic_name
        #: Callbacks for events, watched by executors; set by the node.
        self._watched_events: EndpointEvents | None = None

    @property
    def _endpoints(self) -> tuple[Writer]:
        return (self._writer,)

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
        RCLError
            If the context is shut down.
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
        return len(self._writer.usable().matched_readers())

    @property
    def topic_name(self) -> str:
        """Topic after expansion and remapping."""
        self._writer.usable()
        return self._full_name

    def assert_liveliness(self) -> None:
        """Tell that the publisher lives, if its liveliness is manual."""
        cyclone.assert_liveliness(self._writer.usable().ref)

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
        has_limit = timeout is not None and timeout.nanoseconds >= 0
        limit = timeout.nanoseconds if timeout is not None and has_limit else FOREVER
        return cyclone.wait_for_acks(self._writer.usable().ref, limit)

    def destroy(self) -> None:
        """Delete the publisher. Again is fine."""
        self._writer.close()
