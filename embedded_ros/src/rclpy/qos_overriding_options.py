"""QoS that read-only parameters override."""

from collections.abc import Callable
from typing import Any

from embedded_ros.message_classes import message_class
from embedded_ros.public_names import shown_in
from embedded_ros.qos_overrides import (
    InvalidQosOverridesError,
    QoSOverridingOptions,
    declare_qos_parameters,
)
from embedded_ros.qos_profile import QoSProfile

__all__ = [
    "InvalidQosOverridesError",
    "QoSOverridingOptions",
    "QosCallbackType",
    "declare_qos_parameters",
]

QosCallbackType = Callable[[QoSProfile], Any]

shown_in(__name__, InvalidQosOverridesError, QoSOverridingOptions)


def __getattr__(name: str) -> Any:
    if name == "QosCallbackResult":  # not at once: making message classes takes time
        return message_class("rcl_interfaces/msg/SetParametersResult")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
