"""What the graph tells of a publisher or subscription."""

from dataclasses import dataclass, field
from enum import IntEnum
from typing import Final

from embedded_ros.qos_policies import HistoryPolicy
from embedded_ros.qos_profile import QoSProfile, qos_profile_unknown

__all__ = ["TopicEndpointInfo", "TopicEndpointTypeEnum", "TypeHash"]

_DIGEST_SIZE: Final = 32


class TypeHash:
    """A version and a digest; ``RIHS01_…`` as text.

    Parameters
    ----------
    version : int
        -1: there is no hash.
    value : bytes
        Thirty-two of them.
    """

    __slots__ = ("_parts",)

    def __init__(self, version: int = -1, value: bytes = bytes(_DIGEST_SIZE)) -> None:
        assert isinstance(version, int), f"version: {version!r}"
        assert isinstance(value, bytes), f"value: {value!r}"
        self._parts = (version, value)

    @property
    def version(self) -> int:
        """Version of the hash."""
        return self._parts[0]

    @property
    def value(self) -> bytes:
        """Digest."""
        return self._parts[1]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, TypeHash) and self._parts == other._parts

    __hash__ = None  # type: ignore[assignment]

    def __str__(self) -> str:
        version, digest = self._parts
        is_hash = version > 0 and len(digest) == _DIGEST_SIZE
        return f"RIHS{version:02}_{digest.hex()}" if is_hash else "INVALID"


class TopicEndpointTypeEnum(IntEnum):
    """What an endpoint is."""

    INVALID = 0
    PUBLISHER = 1
    SUBSCRIPTION = 2


@dataclass(kw_only=True)
class TopicEndpointInfo:
    """A publisher or subscription, its node, type and QoS."""

    node_name: str = ""
    node_namespace: str = ""
    topic_type: str = ""
    topic_type_hash: TypeHash = field(default_factory=TypeHash)
    endpoint_type: TopicEndpointTypeEnum = TopicEndpointTypeEnum.INVALID
    endpoint_gid: list[int] = field(default_factory=list)
    qos_profile: QoSProfile = field(default_factory=lambda: qos_profile_unknown)

    def __str__(self) -> str:
        rows = {
            "Node name": self.node_name,
            "Node namespace": self.node_namespace,
            "Topic type": self.topic_type,
            "Topic type hash": self.topic_type_hash,
            "Endpoint type": self.endpoint_type.name,
            "GID": bytes(self.endpoint_gid).hex("."),
        }
        return "\n".join((*_lines(rows), "QoS profile:", *_lines(self._policies(), "  ")))

    def _policies(self) -> dict[str, object]:
        qos = self.qos_profile
        depth = f" ({qos.depth})" if qos.history is HistoryPolicy.KEEP_LAST else ""
        return {
            "Reliability": qos.reliability.name,
            "History (Depth)": qos.history.name + depth,
            "Durability": qos.durability.name,
            "Lifespan": qos.lifespan,
            "Deadline": qos.deadline,
            "Liveliness": qos.liveliness.name,
            "Liveliness lease duration": qos.liveliness_lease_duration,
        }


def _lines(rows: dict[str, object], indent: str = "") -> list[str]:
    return [f"{indent}{title}: {value}" for title, value in rows.items()]
