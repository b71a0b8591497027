"""Policies that are best available: what they become with the peers that are known by now."""

import copy
from collections.abc import Sequence

from embedded_ros.duration import Duration, Infinite
from embedded_ros.qos_policies import DurabilityPolicy, LivelinessPolicy, ReliabilityPolicy
from embedded_ros.qos_profile import (
    DeadlineBestAvailable,
    LivelinessLeaseDurationeBestAvailable,
    QoSProfile,
)

__all__ = ["for_publisher", "for_service", "for_subscription", "is_open"]

_DURATIONS = {
    "deadline": DeadlineBestAvailable,
    "liveliness_lease_duration": LivelinessLeaseDurationeBestAvailable,
}


def is_open(profile: QoSProfile) -> bool:
    """Tell whether a profile leaves a policy to the peers."""
    return (
        profile.reliability == ReliabilityPolicy.BEST_AVAILABLE
        or profile.durability == DurabilityPolicy.BEST_AVAILABLE
        or profile.liveliness == LivelinessPolicy.BEST_AVAILABLE
        or any(getattr(profile, name) == value for name, value in _DURATIONS.items())
    )


def for_subscription(profile: QoSProfile, publishers: Sequence[QoSProfile]) -> QoSProfile:
    """Profile that asks as much as all publishers offer."""
    is_reliable = all(p.reliability == ReliabilityPolicy.RELIABLE for p in publishers)
    is_kept = all(p.durability == DurabilityPolicy.TRANSIENT_LOCAL for p in publishers)
    is_manual = all(p.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC for p in publishers)
    longest = {
        name: max((getattr(p, name) for p in publishers), default=Infinite) for name in _DURATIONS
    }
    return _filled(
        profile, is_reliable=is_reliable, is_kept=is_kept, is_manual=is_manual, durations=longest
    )


def for_publisher(profile: QoSProfile, subscriptions: Sequence[QoSProfile]) -> QoSProfile:
    """Profile that offers what suits all subscriptions."""
    is_manual = any(s.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC for s in subscriptions)
    shortest = {
        name: min((getattr(s, name) for s in subscriptions), default=Infinite)
        for name in _DURATIONS
    }
    return _filled(profile, is_reliable=True, is_kept=True, is_manual=is_manual, durations=shortest)


def for_service(profile: QoSProfile) -> QoSProfile:
    """Profile of services, whatever the peers."""
    return _filled(
        profile,
        is_reliable=True,
        is_kept=False,
        is_manual=False,
        durations=dict.fromkeys(_DURATIONS, Infinite),
    )


def _filled(
    profile: QoSProfile,
    *,
    is_reliable: bool,
    is_kept: bool,
    is_manual: bool,
    durations: dict[str, Duration],
) -> QoSProfile:
    filled = copy.copy(profile)
    if profile.reliability == ReliabilityPolicy.BEST_AVAILABLE:
        reliable, not_reliable = ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT
        filled.reliability = reliable if is_reliable else not_reliable
    if profile.durability == DurabilityPolicy.BEST_AVAILABLE:
        kept, not_kept = DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE
        filled.durability = kept if is_kept else not_kept
    if profile.liveliness == LivelinessPolicy.BEST_AVAILABLE:
        manual, not_manual = LivelinessPolicy.MANUAL_BY_TOPIC, LivelinessPolicy.AUTOMATIC
        filled.liveliness = manual if is_manual else not_manual
    for name, open_value in _DURATIONS.items():
        if getattr(profile, name) == open_value:
            setattr(filled, name, durations[name])
    return filled
