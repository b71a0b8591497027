"""Subscriptions."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from enum import Enum
from typing import Any

from embedded_ros.cdr import ENCAPSULATION, codec
from embedded_ros.endpoint_events import EndpointEvents
from embedded_ros.endpoints import Reader
from rclpy.callback_groups import CallbackGroup
from rclpy.exceptions import InvalidHandle
from rclpy.qos import QoSProfile

__all__ = ["Subscription"]


class Subscription:
    """Receives messages of a topic; made by :meth:`rclpy.node.Node.create_subscription`."""

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
        self._reader = reader
        self._topic_name = topic_name
        #: Callbacks for events, watched by executors; set by the node.
        self._events: EndpointEvents | None = None
        self._read = codec(msg_type._ros_type).read
        self.msg_type = msg_type
        self.topic = topic
        self.callback = callback
        self.callback_group = callback_group
        self.qos_profile = qos_profile
        self.raw = raw

    @property
    def _wait_ref(self) -> int:
        """What a wait set watches."""
        return self._reader.condition

    def _take(self) -> tuple[Callable[..., Any], tuple[Any, ...]] | None:
        """Take a message; the callback and what to call it with."""
        sample = self._reader.take() if self.raw else self._reader.take_decoded(self._decode)
        if sample is None:
            return None
        message, info = sample
        if self._callback_type is Subscription.CallbackType.MessageOnly:
            return self._callback, (message,)
        return self._callback, (message, message_info(info))

    def _decode(self, payload: bytes) -> Any:
        return self._read(payload, len(ENCAPSULATION))

    def get_publisher_count(self) -> int:
        """Number of matched publishers."""
        return len(self._checked().matched_writers())

    @property
    def topic_name(self) -> str:
        """Topic after expansion and remapping."""
        self._checked()
        return self._topic_name

    def _checked(self) -> Reader:
        if self._reader.closed:
            raise InvalidHandle
        return self._reader

    @property
    def callback(self) -> Callable[..., Any]:
        """What is called with each message, and with its info if it takes two arguments."""
        return self._callback

    @callback.setter
    def callback(self, value: Callable[..., Any]) -> None:
        signature = inspect.signature(value)
        for count, kind in enumerate(Subscription.CallbackType, start=1):
            try:
                signature.bind(*[object()] * count)
            except TypeError:
                continue
            self._callback = value
            self._callback_type = kind
            return
        raise RuntimeError(
            "Subscription.__init__(): callback should be either be callable with one argument"
            "(to get only the message) or two (to get message and message info)"
        )

    def destroy(self) -> None:
        """Delete the subscription. Again is fine."""
        self._reader.close()


def message_info(info: Any) -> dict[str, int | None]:
    """What a callback with two arguments gets; Cyclone counts no sequence numbers."""
    return {
        "source_timestamp": info.source_timestamp,
        "received_timestamp": info.source_timestamp,
        "publication_sequence_number": None,
        "reception_sequence_number": None,
    }
