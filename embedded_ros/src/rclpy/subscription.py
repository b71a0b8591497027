"""Subscriptions."""

import inspect
from collections.abc import Callable
from enum import Enum
from typing import Any

from embedded_ros.cdr import ENCAPSULATION, codec
from embedded_ros.endpoint_events import EndpointEvents
from embedded_ros.endpoints import Reader
from embedded_ros.futures import TaskRunner
from rclpy.callback_groups import CallbackGroup
from rclpy.qos import QoSProfile

__all__ = ["Subscription"]


class Subscription:
    """Receives messages of a topic; made by :meth:`rclpy.node.Node.create_subscription`.

    Used after :meth:`destroy` it raises :class:`InvalidHandle`.
    """

    class CallbackType(Enum):
        """What the callback takes."""

        MessageOnly = 0
        WithMessageInfo = 1

    def __init__(
        self,
        reader: Reader,
        msg_type: type[Any],
        topic: str,
        topic_name: str,
        callback: Callable[..., Any],
        callback_group: CallbackGroup,
        qos_profile: QoSProfile,
        raw: bool,
    ) -> None:
        # First of all: it is refused if it cannot be called with a message.
        self.callback = callback
        self.callback_group = callback_group
        self.msg_type = msg_type
        self.topic = topic
        self.qos_profile = qos_profile
        self.raw = raw
        self._reader = reader
        self._deserialize = codec(msg_type._ros_type).read
        self._full_name = topic_name
        #: What a wait set watches.
        self._wait_ref = reader.condition
        #: Callbacks for events, watched by executors; set by the node.
        self._watched_events: EndpointEvents | None = None

    @property
    def _endpoints(self) -> tuple[Reader]:
        return (self._reader,)

    def _take(
        self, _runner: TaskRunner | None = None
    ) -> tuple[Callable[..., Any], tuple[Any, ...]] | None:
        """Take a message; the callback and what to call it with."""
        sample = self._reader.take() if self.raw else self._reader.take_decoded(self._decode)
        if sample is None:
            return None
        if self._wants_info:
            return self._call, (sample[0], message_info(sample[1]))
        return self._call, (sample[0],)

    def _decode(self, payload: bytes) -> Any:
        return self._deserialize(payload, len(ENCAPSULATION))

    def get_publisher_count(self) -> int:
        """Number of matched publishers."""
        return len(self._reader.usable().matched_writers())

    @property
    def topic_name(self) -> str:
        """Topic after expansion and remapping."""
        self._reader.usable()
        return self._full_name

    @property
    def callback(self) -> Callable[..., Any]:
        """What is called with each message, and with its info if it takes two arguments."""
        return self._call

    @callback.setter
    def callback(self, value: Callable[..., Any]) -> None:
        if not (_takes(value, 1) or _takes(value, 2)):
            raise RuntimeError(
                "Subscription.__init__(): callback should be either be callable with one argument"
                "(to get only the message) or two (to get message and message info)"
            )
        self._call = value
        self._wants_info = not _takes(value, 1)

    def destroy(self) -> None:
        """Delete the subscription. Again is fine."""
        self._reader.close()


def _takes(value: Any, count: int) -> bool:
    try:
        inspect.signature(value).bind(*range(count))
    except TypeError:
        return False
    return True


def message_info(info: Any) -> dict[str, int | None]:
    """What a callback with two arguments gets; Cyclone counts no sequence numbers."""
    stamps = dict.fromkeys(("source_timestamp", "received_timestamp"), info.source_timestamp)
    return {**stamps, "publication_sequence_number": None, "reception_sequence_number": None}
