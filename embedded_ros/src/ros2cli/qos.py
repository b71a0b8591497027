"""Quality of service: as the command line asks for it, and as publishers allow it."""

import argparse
import copy
from collections.abc import Sequence

from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSPresetProfiles,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.topic_endpoint_info import TopicEndpointInfo

__all__ = ["hear_all", "profile_of_arguments"]

_POLICIES = {
    "history": HistoryPolicy,
    "reliability": ReliabilityPolicy,
    "durability": DurabilityPolicy,
    "liveliness": LivelinessPolicy,
}


def profile_of_arguments(arguments: argparse.Namespace) -> tuple[QoSProfile, bool]:
    """Profile that the command line asks for, and whether it names more than a preset."""
    # Presets are shared and must not be changed.
    profile = copy.copy(QoSPresetProfiles.get_from_short_key(arguments.qos_profile))
    asked = {name: getattr(arguments, f"qos_{name}") for name in _POLICIES}
    for name, key in asked.items():
        if key is not None:
            setattr(profile, name, _POLICIES[name].get_from_short_key(key))
    if arguments.qos_depth is not None:
        profile.depth = arguments.qos_depth
    return profile, any(value is not None for value in (arguments.qos_depth, *asked.values()))


def hear_all(publishers: Sequence[TopicEndpointInfo], profile: QoSProfile) -> list[str]:
    """Have a subscription's profile ask for what all publishers offer, and no more.

    A subscription hears nothing of a publisher that offers less than it asks for.

    Returns
    -------
    list of str
        What is lost of the better publishers because of the others, in words.
    """
    lost = []
    if publishers:
        reliable = [each.qos_profile.reliability for each in publishers].count(
            ReliabilityPolicy.RELIABLE
        )
        keeping = [each.qos_profile.durability for each in publishers].count(
            DurabilityPolicy.TRANSIENT_LOCAL
        )
        everybody = len(publishers)
        profile.reliability = (
            ReliabilityPolicy.RELIABLE if reliable == everybody else ReliabilityPolicy.BEST_EFFORT
        )
        profile.durability = (
            DurabilityPolicy.TRANSIENT_LOCAL if keeping == everybody else DurabilityPolicy.VOLATILE
        )
        if 0 < reliable < everybody:
            lost.append("is published reliably and best effort: messages may get lost")
        if 0 < keeping < everybody:
            lost.append("is kept for late subscriptions by some publishers only: that is not heard")
    return lost
