"""Quality of service: as options of the command line, and as publishers demand it."""

import argparse
from collections.abc import Iterable

from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSPresetProfiles,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.topic_endpoint_info import TopicEndpointInfo

__all__ = ["add_qos_arguments", "compatible_policies", "copy_profile", "profile_of_arguments"]

_POLICIES = {
    "history": HistoryPolicy,
    "reliability": ReliabilityPolicy,
    "durability": DurabilityPolicy,
    "liveliness": LivelinessPolicy,
}


def add_qos_arguments(parser: argparse.ArgumentParser, default: str) -> None:
    """Add the options for a profile and its policies; `default` is the name of a preset."""
    parser.add_argument(
        "--qos-profile",
        choices=QoSPresetProfiles.short_keys(),
        default=default,
        help="Quality of service preset profile (default: %(default)s)",
    )
    parser.add_argument("--qos-depth", metavar="N", type=int, help="Queue size setting")
    for name, policy in _POLICIES.items():
        parser.add_argument(
            f"--qos-{name}",
            choices=policy.short_keys(),
            help=f"Quality of service {name} setting (overrides that of --qos-profile)",
        )


def copy_profile(profile: QoSProfile) -> QoSProfile:
    """Copy a profile: presets are shared and must not be changed."""
    return QoSProfile(**{name[1:]: getattr(profile, name[1:]) for name in profile.__slots__})


def profile_of_arguments(arguments: argparse.Namespace) -> tuple[QoSProfile, bool]:
    """Profile that the command line asks for, and whether it names a single policy or the depth."""
    profile = copy_profile(QoSPresetProfiles.get_from_short_key(arguments.qos_profile))
    chosen = False
    if arguments.qos_depth is not None:
        profile.depth = arguments.qos_depth
        chosen = True
    for name, policy in _POLICIES.items():
        key = getattr(arguments, f"qos_{name}")
        if key is not None:
            setattr(profile, name, policy.get_from_short_key(key))
            chosen = True
    return profile, chosen


def compatible_policies(
    publishers: Iterable[TopicEndpointInfo], profile: QoSProfile
) -> list[tuple[str, str]]:
    """Make a profile ask for as much as all publishers offer, so that it connects to each.

    Returns
    -------
    list of (str, str)
        A policy that only some of the publishers offer, and what was chosen instead.
    """
    offered = [publisher.qos_profile for publisher in publishers]
    if not offered:
        return []
    compromises = []
    reliable = [qos.reliability == ReliabilityPolicy.RELIABLE for qos in offered]
    latched = [qos.durability == DurabilityPolicy.TRANSIENT_LOCAL for qos in offered]
    profile.reliability = (
        ReliabilityPolicy.RELIABLE if all(reliable) else ReliabilityPolicy.BEST_EFFORT
    )
    profile.durability = (
        DurabilityPolicy.TRANSIENT_LOCAL if all(latched) else DurabilityPolicy.VOLATILE
    )
    if any(reliable) and not all(reliable):
        compromises.append(("QoSReliabilityPolicy.RELIABLE", "QoSReliabilityPolicy.BEST_EFFORT"))
    if any(latched) and not all(latched):
        compromises.append(("QoSDurabilityPolicy.TRANSIENT_LOCAL", "QoSDurabilityPolicy.VOLATILE"))
    return compromises
