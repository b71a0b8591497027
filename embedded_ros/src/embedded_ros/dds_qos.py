"""QoS profiles of rclpy to policies of DDS and back, as rmw_cyclonedds maps them."""

from typing import Any

from cyclonedds.core import Policy, Qos

from embedded_ros.duration import Duration, Infinite
from embedded_ros.qos_policies import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    ReliabilityPolicy,
)
from embedded_ros.qos_profile import QoSProfile

__all__ = ["may_block", "profile_of", "to_dds"]

_INFINITE = 2**63 - 1
_UNLIMITED = -1


def to_dds(profile: QoSProfile, user_data: str) -> Qos:
    """DDS policies of an endpoint.

    Parameters
    ----------
    profile : QoSProfile
        System defaults become what rmw_cyclonedds takes for them.
    user_data : str
        ``typehash=…;``, before it ``clientid=…;`` or ``serviceid=…;`` for services.
    """
    keep_all = profile.history == HistoryPolicy.KEEP_ALL
    history = Policy.History.KeepAll if keep_all else Policy.History.KeepLast(profile.depth or 1)
    policies: list[Any] = [
        history,
        Policy.WriterDataLifecycle(autodispose=False),
        Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=False),
        Policy.Userdata(user_data.encode()),
    ]
    if profile.reliability == ReliabilityPolicy.BEST_EFFORT:
        policies.append(Policy.Reliability.BestEffort)
    else:
        policies.append(Policy.Reliability.Reliable(max_blocking_time=_INFINITE))
    if profile.durability == DurabilityPolicy.TRANSIENT_LOCAL:
        policies.append(Policy.Durability.TransientLocal)
        # Without it a late joiner gets one sample, whatever the history depth.
        policies.append(Policy.DurabilityService(0, history, _UNLIMITED, _UNLIMITED, _UNLIMITED))
    else:
        policies.append(Policy.Durability.Volatile)
    if profile.lifespan.nanoseconds:
        policies.append(Policy.Lifespan(_nanoseconds(profile.lifespan)))
    if profile.deadline.nanoseconds:
        policies.append(Policy.Deadline(_nanoseconds(profile.deadline)))
    lease = _nanoseconds(profile.liveliness_lease_duration) or _INFINITE
    if profile.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC:
        policies.append(Policy.Liveliness.ManualByTopic(lease))
    else:
        policies.append(Policy.Liveliness.Automatic(lease))
    return Qos(*policies)


def may_block(profile: QoSProfile) -> bool:
    """Whether a write with this profile can wait for slow readers."""
    return (
        profile.history == HistoryPolicy.KEEP_ALL
        and profile.reliability != ReliabilityPolicy.BEST_EFFORT
    )


def _nanoseconds(duration: Duration) -> int:
    return _INFINITE if duration >= Infinite else duration.nanoseconds


def _duration(nanoseconds: int) -> Duration:
    return Infinite if nanoseconds >= Infinite.nanoseconds else Duration(nanoseconds=nanoseconds)


def profile_of(qos: Qos) -> QoSProfile:
    """Profile of a discovered endpoint; policies that discovery does not carry are unknown."""
    found: dict[str, Any] = {"history": HistoryPolicy.UNKNOWN, "depth": 0}
    found["lifespan"] = found["deadline"] = found["liveliness_lease_duration"] = Infinite
    found["liveliness"] = LivelinessPolicy.AUTOMATIC
    found["durability"] = DurabilityPolicy.VOLATILE
    found["reliability"] = ReliabilityPolicy.BEST_EFFORT
    for policy in qos:
        match policy:
            case Policy.History.KeepLast():
                found |= {"history": HistoryPolicy.KEEP_LAST, "depth": policy.depth}
            case Policy.History.KeepAll:
                found["history"] = HistoryPolicy.KEEP_ALL
            case Policy.Reliability.Reliable():
                found["reliability"] = ReliabilityPolicy.RELIABLE
            case Policy.Durability.TransientLocal:
                found["durability"] = DurabilityPolicy.TRANSIENT_LOCAL
            case Policy.Lifespan():
                found["lifespan"] = _duration(policy.lifespan)
            case Policy.Deadline():
                found["deadline"] = _duration(policy.deadline)
            case Policy.Liveliness.Automatic():
                found["liveliness_lease_duration"] = _duration(policy.lease_duration)
            case Policy.Liveliness.ManualByTopic():
                found["liveliness"] = LivelinessPolicy.MANUAL_BY_TOPIC
                found["liveliness_lease_duration"] = _duration(policy.lease_duration)
    return QoSProfile(**found)
