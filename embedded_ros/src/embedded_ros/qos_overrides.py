"""Policies of endpoints that read-only parameters override.

The value that a profile has for a policy says how its parameter is written: a duration as its
nanoseconds, an enumerator as its short key, anything else as it is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from embedded_ros.duration import Duration
from embedded_ros.errors import ParameterAlreadyDeclaredException
from embedded_ros.parameter_table import new_descriptor
from embedded_ros.parameter_value import Parameter
from embedded_ros.qos_policies import QoSPolicyEnum, QoSPolicyKind
from embedded_ros.qos_profile import QoSProfile

__all__ = ["InvalidQosOverridesError", "QoSOverridingOptions", "declare_qos_parameters"]


class InvalidQosOverridesError(Exception):
    """The callback rejects the QoS that parameters give."""


@dataclass(frozen=True)
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

    policy_kinds: Iterable[QoSPolicyKind]
    callback: Callable[[QoSProfile], Any] | None = field(default=None, kw_only=True)
    entity_id: str | None = field(default=None, kw_only=True)

    @classmethod
    def with_default_policies(
        cls,
        *,
        callback: Callable[[QoSProfile], Any] | None = None,
        entity_id: str | None = None,
    ) -> QoSOverridingOptions:
        """History, depth and reliability."""
        default = (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY)
        return cls(default, callback=callback, entity_id=entity_id)


class _Node(Protocol):
    def declare_parameter(
        self, name: str, value: Any = None, descriptor: Any = None
    ) -> Parameter: ...

    def get_parameter(self, name: str) -> Parameter: ...


def declare_qos_parameters(
    kind: Literal["publisher", "subscription"],
    node: _Node,
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

    Raises
    ------
    RuntimeError
        If a parameter's value is none of the policy's.
    InvalidQosOverridesError
        If the callback rejects the profile.
    """
    whose = f"{kind} `{topic_name}` with id `{options.entity_id}`"
    owner = kind if options.entity_id is None else f"{kind}_{options.entity_id}"
    for policy in (item.name.lower() for item in options.policy_kinds):
        if (kind, policy) == ("subscription", "lifespan"):
            continue  # only who publishes knows when a sample expires
        name = f"qos_overrides.{topic_name}.{owner}.{policy}"
        default = getattr(profile, policy)
        value = _declared(node, name, _written(default), f"{policy} for {whose}")
        setattr(profile, policy, _read(policy, value, default))
    if options.callback is None:
        return
    verdict = options.callback(profile)
    if not verdict.successful:
        raise InvalidQosOverridesError(
            f"Provided QoS overrides for {whose}, are not valid: {verdict.reason}"
        )


def _declared(node: _Node, name: str, default: Any, description: str) -> Any:
    descriptor = new_descriptor(description=description, read_only=True)
    try:
        return node.declare_parameter(name, default, descriptor).value
    except ParameterAlreadyDeclaredException:
        return node.get_parameter(name).value  # of another endpoint of the same topic


def _written(value: Any) -> Any:
    if isinstance(value, Duration):
        return value.nanoseconds
    if not isinstance(value, QoSPolicyEnum):
        return value
    if value.name == "UNKNOWN":
        raise ValueError("User provided QoS profile is invalid")
    return value.short_key


def _read(policy: str, written: Any, default: Any) -> Any:
    if isinstance(default, Duration):
        return Duration(nanoseconds=written)
    if not isinstance(default, QoSPolicyEnum):
        return written
    if written.lower() not in default.short_keys():
        raise RuntimeError(f"Unexpected QoS override for policy `{policy}`: `{written}`")
    return type(default)[written.upper()]
