"""What happens to a writer or reader besides samples: matches, missed deadlines and the like."""

import ctypes as ct
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, Final, NamedTuple

from embedded_ros import cyclone
from embedded_ros.endpoints import Reader, Writer
from embedded_ros.futures import TaskRunner
from embedded_ros.qos_policies import QoSPolicyKind
from embedded_ros.work_loop import Group

__all__ = [
    "LIVELINESS_CHANGED",
    "LIVELINESS_LOST",
    "MESSAGE_LOST",
    "OFFERED_DEADLINE_MISSED",
    "OFFERED_INCOMPATIBLE_QOS",
    "PUBLICATION_MATCHED",
    "REQUESTED_DEADLINE_MISSED",
    "REQUESTED_INCOMPATIBLE_QOS",
    "SUBSCRIPTION_MATCHED",
    "EndpointEvents",
    "IncompatibleQoS",
    "IncompatibleType",
    "LivelinessChanged",
    "LivelinessLost",
    "Matched",
    "MessageLost",
    "OfferedDeadlineMissed",
    "RequestedDeadlineMissed",
    "Status",
]


@dataclass(frozen=True)
class _Counted:
    """How often something happened in all, and since the last event."""

    total_count: int
    total_count_change: int


class RequestedDeadlineMissed(_Counted):
    """No message came within the deadline of a subscription."""


class OfferedDeadlineMissed(_Counted):
    """A publisher published nothing within its deadline."""


class LivelinessLost(_Counted):
    """A publisher did not assert its liveliness within its lease."""


class MessageLost(_Counted):
    """Messages did not reach a subscription."""


class IncompatibleType(_Counted):
    """A topic has another type elsewhere; like ``rmw_cyclonedds`` we never tell."""


@dataclass(frozen=True)
class LivelinessChanged:
    """Publishers of a topic came to life or lost their liveliness."""

    alive_count: int
    not_alive_count: int
    alive_count_change: int
    not_alive_count_change: int


@dataclass(frozen=True)
class IncompatibleQoS(_Counted):
    """A peer was found whose QoS does not fit; `last_policy_kind` is a ``QoSPolicyKind``."""

    last_policy_kind: int


@dataclass(frozen=True)
class Matched(_Counted):
    """A peer was found or went away."""

    current_count: int
    current_count_change: int


class Status(NamedTuple):
    """A DDS status: its bit, the function that reads and resets it, and what that gives."""

    mask: int
    function: str
    information: type[Any]


OFFERED_DEADLINE_MISSED: Final = Status(
    1 << 1, "dds_get_offered_deadline_missed_status", OfferedDeadlineMissed
)
REQUESTED_DEADLINE_MISSED: Final = Status(
    1 << 2, "dds_get_requested_deadline_missed_status", RequestedDeadlineMissed
)
OFFERED_INCOMPATIBLE_QOS: Final = Status(
    1 << 3, "dds_get_offered_incompatible_qos_status", IncompatibleQoS
)
REQUESTED_INCOMPATIBLE_QOS: Final = Status(
    1 << 4, "dds_get_requested_incompatible_qos_status", IncompatibleQoS
)
MESSAGE_LOST: Final = Status(1 << 5, "dds_get_sample_lost_status", MessageLost)
LIVELINESS_LOST: Final = Status(1 << 9, "dds_get_liveliness_lost_status", LivelinessLost)
LIVELINESS_CHANGED: Final = Status(1 << 10, "dds_get_liveliness_changed_status", LivelinessChanged)
PUBLICATION_MATCHED: Final = Status(1 << 11, "dds_get_publication_matched_status", Matched)
SUBSCRIPTION_MATCHED: Final = Status(1 << 12, "dds_get_subscription_matched_status", Matched)

#: rclpy's kind of the policies that DDS reports by number.
_POLICY_KINDS: Final = {
    2: QoSPolicyKind.DURABILITY,
    4: QoSPolicyKind.DEADLINE,
    8: QoSPolicyKind.LIVELINESS,
    11: QoSPolicyKind.RELIABILITY,
    13: QoSPolicyKind.HISTORY,
    21: QoSPolicyKind.LIFESPAN,
}


class EndpointEvents:
    """The callbacks for the statuses of one endpoint; executors watch it as they do subscriptions.

    Parameters
    ----------
    endpoint : Writer or Reader
    callbacks : dict
        Callback by status; each is called with the information of its status.
    callback_group : CallbackGroup
    """

    def __init__(
        self,
        endpoint: Writer | Reader,
        callbacks: dict[Status, Callable[[Any], Any]],
        callback_group: Group,
    ) -> None:
        self._endpoint = endpoint
        self._callbacks = callbacks
        self._wait_ref = endpoint.ref
        self.callback_group = callback_group
        # What is not asked for must not wake the executor. Changes before this are kept.
        cyclone.set_status_mask(endpoint.ref, sum(status.mask for status in callbacks))

    def _take(
        self, _runner: TaskRunner | None = None
    ) -> tuple[Callable[[Any], Any], tuple[Any]] | None:
        """Take one change; others go on waking the executor."""
        if self._endpoint.closed:
            return None
        for status, callback in self._callbacks.items():
            if cyclone.take_status(self._endpoint.ref, status.mask):
                return callback, (_information(status, self._endpoint.ref),)
        return None


def _information(status: Status, entity: int) -> Any:
    # These structures begin with numbers of four bytes; a handle that may follow is not needed.
    numbers = (ct.c_int32 * 8)()
    cyclone.get_status(status.function, entity, numbers)
    values = list(numbers)[: len(fields(status.information))]
    if status.information is IncompatibleQoS:
        values[2] = int(_POLICY_KINDS.get(values[2], QoSPolicyKind.INVALID))
    return status.information(*values)
