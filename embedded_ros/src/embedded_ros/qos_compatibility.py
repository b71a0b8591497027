"""Whether profiles of quality of service fit each other. Texts are those of rmw."""

from enum import IntEnum

from embedded_ros.qos_policies import DurabilityPolicy, LivelinessPolicy
from embedded_ros.qos_profile import QoSProfile

__all__ = ["QoSCompatibility", "qos_check_compatible"]


class QoSCompatibility(IntEnum):
    """Whether a publisher and a subscription exchange messages."""

    OK = 0
    WARNING = 1
    ERROR = 2


def qos_check_compatible(
    publisher_qos: QoSProfile, subscription_qos: QoSProfile
) -> tuple[QoSCompatibility, str]:
    """Check whether two profiles are compatible.

    Returns
    -------
    QoSCompatibility
        ``WARNING`` if it depends on values that are not known yet.
    str
        The reasons, separated by semicolons.
    """
    errors = _certain(publisher_qos, subscription_qos)
    if errors:
        return QoSCompatibility.ERROR, "".join(f"ERROR: {error};" for error in errors)
    warnings_ = _possible(publisher_qos, subscription_qos)
    if warnings_:
        return QoSCompatibility.WARNING, "".join(f"WARNING: {text};" for text in warnings_)
    return QoSCompatibility.OK, ""


def _certain(offered: QoSProfile, asked: QoSProfile) -> list[str]:
    """Why the subscription gets nothing."""
    found = []
    if offered.reliability.short_key == "best_effort" and asked.reliability.short_key == "reliable":
        found.append("Best effort publisher and reliable subscription")
    if (
        offered.durability == DurabilityPolicy.VOLATILE
        and asked.durability == DurabilityPolicy.TRANSIENT_LOCAL
    ):
        found.append("Volatile publisher and transient local subscription")
    if asked.deadline.nanoseconds and not offered.deadline.nanoseconds:
        found.append("Subscription has a deadline, but publisher does not")
    elif asked.deadline.nanoseconds and asked.deadline < offered.deadline:
        found.append("Subscription deadline is less than publisher deadline")
    if (
        offered.liveliness == LivelinessPolicy.AUTOMATIC
        and asked.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC
    ):
        found.append("Publisher's liveliness is automatic and subscription's is manual by topic")
    asked_lease, offered_lease = asked.liveliness_lease_duration, offered.liveliness_lease_duration
    if asked_lease.nanoseconds and not offered_lease.nanoseconds:
        found.append("Subscription has a liveliness lease duration, but publisher does not")
    elif asked_lease.nanoseconds and asked_lease < offered_lease:
        found.append("Subscription liveliness lease duration is less than publisher")
    return found


def _possible(offered: QoSProfile, asked: QoSProfile) -> list[str]:
    """What may go wrong where a side leaves a policy to the system."""
    found = []
    for policy, name, demanding, lenient, demand, offer in (
        # rmw misspells one of the names.
        (
            "reliability",
            "reliability",
            "reliable",
            "best_effort",
            "Reliable subscription, but publisher is",
            "Best effort publisher, but subscription is",
        ),
        (
            "durability",
            "durabilty",
            "transient_local",
            "volatile",
            "Transient local subscription, but publisher is",
            "Volatile publisher, but subscription is",
        ),
        (
            "liveliness",
            "liveliness",
            "manual_by_topic",
            "automatic",
            "Subscription's liveliness is manual by topic, but publisher's is",
            "Publisher's liveliness is automatic, but subscription's is",
        ),
    ):
        given = getattr(offered, policy).short_key
        wanted = getattr(asked, policy).short_key
        given_is_open = given in ("system_default", "unknown")
        wanted_is_open = wanted in ("system_default", "unknown")
        if given_is_open and wanted_is_open:
            found.append(f"Publisher {name} is {given} and subscription {policy} is {wanted}")
        elif given_is_open and wanted == demanding:
            found.append(f"{demand} {given}")
        elif wanted_is_open and given == lenient:
            found.append(f"{offer} {wanted}")
    return found
