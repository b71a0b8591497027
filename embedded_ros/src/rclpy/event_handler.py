"""Callbacks for what happens to publishers and subscriptions besides messages."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from embedded_ros import endpoint_events
from embedded_ros.endpoint_events import IncompatibleQoS as QoSRequestedIncompatibleQoSInfo
from embedded_ros.endpoint_events import IncompatibleType as IncompatibleTypeInfo
from embedded_ros.endpoint_events import LivelinessChanged as QoSLivelinessChangedInfo
from embedded_ros.endpoint_events import LivelinessLost as QoSLivelinessLostInfo
from embedded_ros.endpoint_events import Matched as QoSPublisherMatchedInfo
from embedded_ros.endpoint_events import MessageLost as QoSMessageLostInfo
from embedded_ros.endpoint_events import OfferedDeadlineMissed as QoSOfferedDeadlineMissedInfo
from embedded_ros.endpoint_events import RequestedDeadlineMissed as QoSRequestedDeadlineMissedInfo
from embedded_ros.errors import UnsupportedEventTypeError
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.qos import qos_policy_name_from_kind

__all__ = [
    "IncompatibleTypeInfo",
    "PublisherEventCallbacks",
    "QoSLivelinessChangedInfo",
    "QoSLivelinessLostInfo",
    "QoSMessageLostInfo",
    "QoSOfferedDeadlineMissedInfo",
    "QoSOfferedIncompatibleQoSInfo",
    "QoSPublisherMatchedInfo",
    "QoSRequestedDeadlineMissedInfo",
    "QoSRequestedIncompatibleQoSInfo",
    "QoSSubscriptionMatchedInfo",
    "SubscriptionEventCallbacks",
    "UnsupportedEventTypeError",
]

QoSOfferedIncompatibleQoSInfo = QoSRequestedIncompatibleQoSInfo
QoSSubscriptionMatchedInfo = QoSPublisherMatchedInfo

_Callbacks = dict[endpoint_events.Status, Callable[[Any], Any]]
_Table = dict[endpoint_events.Status, Callable[[Any], Any] | None]


@dataclass(kw_only=True, eq=False)
class SubscriptionEventCallbacks:
    """Callbacks for events of a subscription.

    Parameters
    ----------
    deadline : callable, optional
        No message came within the requested deadline.
    incompatible_qos : callable, optional
        A publisher with incompatible QoS was found; by default a warning is logged.
    liveliness : callable, optional
        The liveliness of a publisher changed.
    message_lost : callable, optional
    incompatible_type : callable, optional
        A publisher of another type was found. Cyclone DDS never calls it.
    matched : callable, optional
        A publisher was found or went away.
    use_default_callbacks : bool
    """

    deadline: Callable[[QoSRequestedDeadlineMissedInfo], Any] | None = None
    incompatible_qos: Callable[[QoSRequestedIncompatibleQoSInfo], Any] | None = None
    liveliness: Callable[[QoSLivelinessChangedInfo], Any] | None = None
    message_lost: Callable[[QoSMessageLostInfo], Any] | None = None
    incompatible_type: Callable[[IncompatibleTypeInfo], Any] | None = None
    matched: Callable[[QoSSubscriptionMatchedInfo], Any] | None = None
    use_default_callbacks: bool = True

    def _by_status(self, logger: RcutilsLogger, topic_name: str) -> _Callbacks:
        text = (
            f"New publisher discovered on topic '{topic_name}', offering incompatible QoS. "
            "No messages will be received from it."
        )
        incompatible = self.incompatible_qos
        if incompatible is None and self.use_default_callbacks:
            incompatible = _warning(logger, text)
        return _given(
            {
                endpoint_events.REQUESTED_DEADLINE_MISSED: self.deadline,
                endpoint_events.REQUESTED_INCOMPATIBLE_QOS: incompatible,
                endpoint_events.LIVELINESS_CHANGED: self.liveliness,
                endpoint_events.MESSAGE_LOST: self.message_lost,
                endpoint_events.SUBSCRIPTION_MATCHED: self.matched,
            }
        )


@dataclass(kw_only=True, eq=False)
class PublisherEventCallbacks:
    """Callbacks for events of a publisher.

    Parameters
    ----------
    deadline : callable, optional
        Nothing was published within the offered deadline.
    liveliness : callable, optional
        The publisher did not assert its liveliness in time.
    incompatible_qos : callable, optional
        A subscription with incompatible QoS was found; by default a warning is logged.
    incompatible_type : callable, optional
        A subscription of another type was found. Cyclone DDS never calls it.
    matched : callable, optional
        A subscription was found or went away.
    use_default_callbacks : bool
    """

    deadline: Callable[[QoSOfferedDeadlineMissedInfo], Any] | None = None
    liveliness: Callable[[QoSLivelinessLostInfo], Any] | None = None
    incompatible_qos: Callable[[QoSOfferedIncompatibleQoSInfo], Any] | None = None
    incompatible_type: Callable[[IncompatibleTypeInfo], Any] | None = None
    matched: Callable[[QoSPublisherMatchedInfo], Any] | None = None
    use_default_callbacks: bool = True

    def _by_status(self, logger: RcutilsLogger, topic_name: str) -> _Callbacks:
        text = (
            f"New subscription discovered on topic '{topic_name}', requesting incompatible QoS. "
            "No messages will be sent to it."
        )
        incompatible = self.incompatible_qos
        if incompatible is None and self.use_default_callbacks:
            incompatible = _warning(logger, text)
        return _given(
            {
                endpoint_events.OFFERED_DEADLINE_MISSED: self.deadline,
                endpoint_events.LIVELINESS_LOST: self.liveliness,
                endpoint_events.OFFERED_INCOMPATIBLE_QOS: incompatible,
                endpoint_events.PUBLICATION_MATCHED: self.matched,
            }
        )


def _warning(logger: RcutilsLogger, text: str) -> Callable[[Any], None]:
    def warn(event: QoSRequestedIncompatibleQoSInfo) -> None:
        policy = qos_policy_name_from_kind(event.last_policy_kind)
        logger.warning(f"{text} Last incompatible policy: {policy}")

    return warn


def _given(table: _Table) -> _Callbacks:
    return {status: callback for status, callback in table.items() if callback is not None}
