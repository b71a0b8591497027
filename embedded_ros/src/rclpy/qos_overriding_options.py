"""QoS that read-only parameters override."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from embedded_ros.qos_policies import QoSPolicyEnum
from rclpy.duration import Duration
from rclpy.exceptions import ParameterAlreadyDeclaredException
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
)

if TYPE_CHECKING:
    from embedded_ros.node_parameters import NodeParameters

__all__ = ["InvalidQosOverridesError", "QoSOverridingOptions"]

_ENUMERATIONS: dict[QoSPolicyKind, type[QoSPolicyEnum]] = {
    QoSPolicyKind.HISTORY: HistoryPolicy,
    QoSPolicyKind.RELIABILITY: ReliabilityPolicy,
    QoSPolicyKind.DURABILITY: DurabilityPolicy,
    QoSPolicyKind.LIVELINESS: LivelinessPolicy,
}
_DURATIONS = (
    QoSPolicyKind.LIFESPAN,
    QoSPolicyKind.DEADLINE,
    QoSPolicyKind.LIVELINESS_LEASE_DURATION,
)


class InvalidQosOverridesError(Exception):
    """The callback rejects the QoS that parameters give."""


class QoSOverridingOptions:
    """Which policies of an endpoint are parameters.

    Parameters
    ----------
    policy_kinds : iterable of QoSPolicyKind
    callback : callable, optional
        Takes the profile in force and returns a ``SetParametersResult``.
    entity_id : str, optional
        Tells several endpoints of one topic apart.
    """

    def __init__(
        self,
        policy_kinds: Iterable[QoSPolicyKind],
        *,
        callback: Callable[[QoSProfile], Any] | None = None,
        entity_id: str | None = None,
    ) -> None:
        self._policy_kinds = policy_kinds
        self._callback = callback
        self._entity_id = entity_id

    @property
    def policy_kinds(self) -> Iterable[QoSPolicyKind]:
        """Policies that are parameters."""
        return self._policy_kinds

    @property
    def callback(self) -> Callable[[QoSProfile], Any] | None:
        """What accepts or rejects the profile."""
        return self._callback

    @property
    def entity_id(self) -> str | None:
        """Part of the parameters' names."""
        return self._entity_id

    @classmethod
    def with_default_policies(
        cls,
        *,
        callback: Callable[[QoSProfile], Any] | None = None,
        entity_id: str | None = None,
    ) -> QoSOverridingOptions:
        """History, depth and reliability."""
        return cls(
            (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY),
            callback=callback,
            entity_id=entity_id,
        )


def declare_qos_parameters(
    kind: str,
    node: NodeParameters,
    topic_name: str,
    profile: QoSProfile,
    options: QoSOverridingOptions,
) -> None:
    """Declare the parameters of an endpoint and change its profile to what they say.

    Parameters
    ----------
    kind : {'publisher', 'subscription'}
    node : Node
    topic_name : str
        Full name.
    profile : QoSProfile
        Holds the defaults; changed in place.
    options : QoSOverridingOptions
    """
    from rcl_interfaces.msg import ParameterDescriptor

    suffix = "" if options.entity_id is None else f"_{options.entity_id}"
    about = f"for {kind} `{topic_name}` with id `{options.entity_id}`"
    for policy in options.policy_kinds:
        if policy is QoSPolicyKind.LIFESPAN and kind == "subscription":
            continue
        attribute = policy.name.lower()
        name = f"qos_overrides.{topic_name}.{kind}{suffix}.{attribute}"
        descriptor = ParameterDescriptor(description=f"{attribute} {about}", read_only=True)
        try:
            parameter = node.declare_parameter(
                name, _parameter_value(getattr(profile, attribute)), descriptor
            )
        except ParameterAlreadyDeclaredException:
            parameter = node.get_parameter(name)
        setattr(profile, attribute, _policy_value(policy, parameter.value))
    if options.callback is not None:
        result = options.callback(profile)
        if not result.successful:
            raise InvalidQosOverridesError(
                f"Provided QoS overrides {about}, are not valid: {result.reason}"
            )


def _parameter_value(value: Any) -> Any:
    if isinstance(value, Duration):
        return value.nanoseconds
    if isinstance(value, QoSPolicyEnum):
        if value.short_key == "unknown":
            raise ValueError("User provided QoS profile is invalid")
        return value.short_key
    return value


def _policy_value(policy: QoSPolicyKind, value: Any) -> Any:
    if policy in _DURATIONS:
        return Duration(nanoseconds=value)
    if policy in _ENUMERATIONS:
        try:
            return _ENUMERATIONS[policy][value.upper()]
        except KeyError:
            raise RuntimeError(
                f"Unexpected QoS override for policy `{policy.name.lower()}`: `{value}`"
            ) from None
    return value
