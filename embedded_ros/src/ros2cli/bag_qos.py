"""Quality of service in bags: what publishers offered, and what to ask and offer in turn."""

from collections.abc import Sequence
from typing import TypeVar

from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)

from rclpy.duration import Duration
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.topic_endpoint_info import TopicEndpointInfo
from ros2cli.qos import hear_all

__all__ = ["offered_by", "profile_to_offer", "profile_to_request"]

#: Samples that wait for the recorder while it writes; only memory speaks against more.
_REQUEST_DEPTH = 1000
_OFFER_DEPTH = 10
_NANOSECONDS = 1_000_000_000

PolicyT = TypeVar("PolicyT", ReliabilityPolicy, DurabilityPolicy, LivelinessPolicy)


def offered_by(publishers: Sequence[TopicEndpointInfo]) -> list[Qos]:
    """Profiles of publishers, as the metadata of a bag holds them."""
    return [_to_bag(publisher.qos_profile) for publisher in publishers]


def profile_to_request(publishers: Sequence[TopicEndpointInfo]) -> tuple[QoSProfile, list[str]]:
    """Profile of a subscription that hears all publishers, and what is lost by that, in words."""
    profile = QoSProfile(depth=_REQUEST_DEPTH)
    return profile, hear_all(publishers, profile)


def profile_to_offer(recorded: Sequence[Qos]) -> tuple[QoSProfile, bool]:
    """Profile of a publisher that stands for the recorded ones.

    Returns
    -------
    QoSProfile
        The default where the recorded publishers differed.
    bool
        Whether they differed.
    """
    default = QoSProfile(depth=_OFFER_DEPTH)
    if not recorded:
        return default, False
    # History and lifespan do not decide who hears whom.
    kinds = {
        qos._replace(history=QosHistory.UNKNOWN, depth=0, lifespan=QosTime(0, 0))
        for qos in recorded
    }
    if len(kinds) > 1:
        return default, True
    return _from_bag(recorded[0]), False


def _to_bag(profile: QoSProfile) -> Qos:
    return Qos(
        history=QosHistory(profile.history.value),
        depth=profile.depth,
        reliability=QosReliability(profile.reliability.value),
        durability=QosDurability(profile.durability.value),
        deadline=_to_bag_time(profile.deadline),
        lifespan=_to_bag_time(profile.lifespan),
        liveliness=QosLiveliness(profile.liveliness.value),
        liveliness_lease_duration=_to_bag_time(profile.liveliness_lease_duration),
        avoid_ros_namespace_conventions=profile.avoid_ros_namespace_conventions,
    )


def _from_bag(qos: Qos) -> QoSProfile:
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=_OFFER_DEPTH,
        reliability=_known(ReliabilityPolicy, qos.reliability.value),
        durability=_known(DurabilityPolicy, qos.durability.value),
        deadline=_from_bag_time(qos.deadline),
        lifespan=_from_bag_time(qos.lifespan),
        liveliness=_known(LivelinessPolicy, qos.liveliness.value),
        liveliness_lease_duration=_from_bag_time(qos.liveliness_lease_duration),
        avoid_ros_namespace_conventions=qos.avoid_ros_namespace_conventions,
    )


def _known(policy: type[PolicyT], value: int) -> PolicyT:
    """Policy of a number; that of the system where it names nothing that a publisher can have."""
    found = policy(value) if value in list(policy) else policy["UNKNOWN"]
    return policy["SYSTEM_DEFAULT"] if found == policy["UNKNOWN"] else found


def _to_bag_time(duration: Duration) -> QosTime:
    return QosTime(*divmod(duration.nanoseconds, _NANOSECONDS))


def _from_bag_time(time: QosTime) -> Duration:
    # Older bags hold what their middleware took for infinity, which is more than a Duration can.
    nanoseconds = time.sec * _NANOSECONDS + time.nsec
    return Duration(nanoseconds=min(nanoseconds, 2**63 - 1))
