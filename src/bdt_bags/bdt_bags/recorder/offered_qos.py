"""Profiles that publishers offer, as the metadata of a bag hold them."""

import yaml
from rclpy.duration import Duration
from rclpy.qos import QoSProfile

_NANOSECONDS = 1_000_000_000
_LONGEST = 2**63 - 1
"""What ROS 2 takes for unlimited [ns]."""


def offered_qos_text(profiles: list[QoSProfile]) -> str:
    """Return QoS profiles as a YAML list, version 9 of rosbag2's metadata."""
    return yaml.safe_dump([_described(profile) for profile in profiles], sort_keys=False).strip()


def _described(profile: QoSProfile) -> dict[str, object]:
    return {
        "history": profile.history.name.lower(),
        "depth": profile.depth,
        "reliability": profile.reliability.name.lower(),
        "durability": profile.durability.name.lower(),
        "deadline": _time(profile.deadline),
        "lifespan": _time(profile.lifespan),
        "liveliness": _known(profile.liveliness.name.lower()),
        "liveliness_lease_duration": _time(profile.liveliness_lease_duration),
        "avoid_ros_namespace_conventions": profile.avoid_ros_namespace_conventions,
    }


def _known(liveliness: str) -> str:
    # A profile that leaves it to the system is automatic, the only kind that DDS has by default.
    return "automatic" if liveliness == "system_default" else liveliness


def _time(duration: Duration) -> dict[str, int]:
    # A profile that sets no time has zero there, which means unlimited.
    nanoseconds = duration.nanoseconds or _LONGEST
    seconds, rest = divmod(min(nanoseconds, _LONGEST), _NANOSECONDS)
    return {"sec": seconds, "nsec": rest}
