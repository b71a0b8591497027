"""Quality of service: policies, profiles and presets."""

import warnings
from enum import Enum
from typing import Any, Final

from embedded_ros.qos_compatibility import QoSCompatibility, qos_check_compatible
from embedded_ros.qos_policies import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSPolicyKind,
    ReliabilityPolicy,
)
from rclpy.duration import Duration, Infinite

__all__ = [
    "DeadlineBestAvailable",
    "DurabilityPolicy",
    "HistoryPolicy",
    "InvalidQoSProfileException",
    "LivelinessPolicy",
    "QoSCompatibility",
    "QoSDurabilityPolicy",
    "QoSHistoryPolicy",
    "QoSLivelinessPolicy",
    "QoSPolicyKind",
    "QoSPresetProfiles",
    "QoSProfile",
    "QoSReliabilityPolicy",
    "ReliabilityPolicy",
    "qos_check_compatible",
    "qos_policy_name_from_kind",
    "qos_profile_action_status_default",
    "qos_profile_best_available",
    "qos_profile_default",
    "qos_profile_parameter_events",
    "qos_profile_parameters",
    "qos_profile_sensor_data",
    "qos_profile_services_default",
    "qos_profile_system_default",
    "qos_profile_unknown",
]


def qos_policy_name_from_kind(policy_kind: QoSPolicyKind | int) -> str:
    """Name of a policy kind."""
    return QoSPolicyKind(policy_kind).name


class InvalidQoSProfileException(Exception):
    """A profile lacks a setting that it needs."""

    def __init__(self, *args: object) -> None:
        super().__init__("Invalid QoSProfile", *args)


QoSHistoryPolicy = HistoryPolicy
QoSReliabilityPolicy = ReliabilityPolicy
QoSDurabilityPolicy = DurabilityPolicy
QoSLivelinessPolicy = LivelinessPolicy


def _of_type(name: str, value: Any, *types: type) -> Any:
    assert isinstance(value, types), f"{name}: {value!r}"
    return value


class QoSProfile:
    """The policies of an endpoint.

    Parameters
    ----------
    history : HistoryPolicy
        Keep-last if only `depth` is given.
    depth : int
    reliability : ReliabilityPolicy
        Reliable by default.
    durability : DurabilityPolicy
        Volatile by default.
    lifespan, deadline, liveliness_lease_duration : Duration
        Zero: unspecified.
    liveliness : LivelinessPolicy
    avoid_ros_namespace_conventions : bool

    Raises
    ------
    InvalidQoSProfileException
        If neither `history` nor `depth` is given, or keep-last without a depth.
    """

    __slots__ = (  # noqa: RUF023 - the order in which they are printed
        "_history",
        "_depth",
        "_reliability",
        "_durability",
        "_lifespan",
        "_deadline",
        "_liveliness",
        "_liveliness_lease_duration",
        "_avoid_ros_namespace_conventions",
    )

    def __init__(self, **kwargs: Any) -> None:
        assert all(f"_{key}" in self.__slots__ for key in kwargs), (
            f"Invalid arguments passed to constructor: {kwargs.keys()!r}"
        )
        if "history" not in kwargs:
            if "depth" not in kwargs:
                raise InvalidQoSProfileException("History and/or depth settings are required.")
            kwargs["history"] = HistoryPolicy.KEEP_LAST
        self.history = kwargs["history"]
        if self.history == HistoryPolicy.KEEP_LAST and "depth" not in kwargs:
            raise InvalidQoSProfileException("History set to KEEP_LAST without a depth setting.")
        self.depth = kwargs.get("depth", 10)
        self.reliability = kwargs.get("reliability", ReliabilityPolicy.RELIABLE)
        self.durability = kwargs.get("durability", DurabilityPolicy.VOLATILE)
        self.lifespan = kwargs.get("lifespan", Duration())
        self.deadline = kwargs.get("deadline", Duration())
        self.liveliness = kwargs.get("liveliness", LivelinessPolicy.SYSTEM_DEFAULT)
        self.liveliness_lease_duration = kwargs.get("liveliness_lease_duration", Duration())
        self.avoid_ros_namespace_conventions = kwargs.get("avoid_ros_namespace_conventions", False)

    @property
    def history(self) -> HistoryPolicy:
        """How many samples are kept."""
        return self._history

    @history.setter
    def history(self, value: HistoryPolicy | int) -> None:
        self._history = HistoryPolicy(_of_type("history", value, int))

    @property
    def depth(self) -> int:
        """Number of samples that keep-last keeps."""
        return self._depth

    @depth.setter
    def depth(self, value: int) -> None:
        _of_type("depth", value, int)
        if self.history == HistoryPolicy.KEEP_LAST and value == 0:
            warnings.warn(
                "A zero depth with KEEP_LAST doesn't make sense; no data could be stored. "
                "This will be interpreted as SYSTEM_DEFAULT",
                stacklevel=2,
            )
        self._depth = value

    @property
    def reliability(self) -> ReliabilityPolicy:
        """Whether lost samples are sent again."""
        return self._reliability

    @reliability.setter
    def reliability(self, value: ReliabilityPolicy | int) -> None:
        self._reliability = ReliabilityPolicy(_of_type("reliability", value, int))

    @property
    def durability(self) -> DurabilityPolicy:
        """Whether late joiners get earlier samples."""
        return self._durability

    @durability.setter
    def durability(self, value: DurabilityPolicy | int) -> None:
        self._durability = DurabilityPolicy(_of_type("durability", value, int))

    @property
    def lifespan(self) -> Duration:
        """Age at which a sample expires."""
        return self._lifespan

    @lifespan.setter
    def lifespan(self, value: Duration) -> None:
        self._lifespan: Duration = _of_type("lifespan", value, Duration)

    @property
    def deadline(self) -> Duration:
        """Longest time between samples."""
        return self._deadline

    @deadline.setter
    def deadline(self, value: Duration) -> None:
        self._deadline: Duration = _of_type("deadline", value, Duration)

    @property
    def liveliness(self) -> LivelinessPolicy:
        """Who asserts that a publisher lives."""
        return self._liveliness

    @liveliness.setter
    def liveliness(self, value: LivelinessPolicy | int) -> None:
        self._liveliness = LivelinessPolicy(_of_type("liveliness", value, int))

    @property
    def liveliness_lease_duration(self) -> Duration:
        """Time after which a publisher that asserts nothing is taken for dead."""
        return self._liveliness_lease_duration

    @liveliness_lease_duration.setter
    def liveliness_lease_duration(self, value: Duration) -> None:
        self._liveliness_lease_duration: Duration = _of_type("lease duration", value, Duration)

    @property
    def avoid_ros_namespace_conventions(self) -> bool:
        """Whether the DDS topic lacks the prefix ``rt``."""
        return self._avoid_ros_namespace_conventions

    @avoid_ros_namespace_conventions.setter
    def avoid_ros_namespace_conventions(self, value: bool) -> None:
        self._avoid_ros_namespace_conventions: bool = _of_type("avoid", value, bool)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, QoSProfile):
            return False
        return all(getattr(self, slot) == getattr(other, slot) for slot in self.__slots__)

    __hash__ = None  # type: ignore[assignment]

    def __str__(self) -> str:
        values = ", ".join(f"{slot[1:]}={getattr(self, slot)}" for slot in self.__slots__)
        return f"{type(self).__name__}({values})"


_BEST_AVAILABLE_DURATION = Duration(nanoseconds=Infinite.nanoseconds - 1)
DeadlineBestAvailable: Final = _BEST_AVAILABLE_DURATION
# The misspelling is rclpy's.
LivelinessLeaseDurationeBestAvailable: Final = _BEST_AVAILABLE_DURATION

qos_profile_unknown: Final = QoSProfile(
    history=HistoryPolicy.UNKNOWN,
    depth=0,
    reliability=ReliabilityPolicy.UNKNOWN,
    durability=DurabilityPolicy.UNKNOWN,
    liveliness=LivelinessPolicy.UNKNOWN,
)
qos_profile_default: Final = QoSProfile(depth=10)
qos_profile_system_default: Final = QoSProfile(
    history=HistoryPolicy.SYSTEM_DEFAULT,
    depth=0,
    reliability=ReliabilityPolicy.SYSTEM_DEFAULT,
    durability=DurabilityPolicy.SYSTEM_DEFAULT,
)
qos_profile_sensor_data: Final = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
qos_profile_services_default: Final = QoSProfile(depth=10)
qos_profile_parameters: Final = QoSProfile(depth=1000)
qos_profile_parameter_events: Final = QoSProfile(depth=1000)
qos_profile_best_available: Final = QoSProfile(
    depth=10,
    reliability=ReliabilityPolicy.BEST_AVAILABLE,
    durability=DurabilityPolicy.BEST_AVAILABLE,
    deadline=DeadlineBestAvailable,
    liveliness=LivelinessPolicy.BEST_AVAILABLE,
    liveliness_lease_duration=LivelinessLeaseDurationeBestAvailable,
)
qos_profile_action_status_default: Final = QoSProfile(
    depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL
)


class QoSPresetProfiles(Enum):
    """The predefined profiles."""

    UNKNOWN = qos_profile_unknown
    DEFAULT = qos_profile_default
    SYSTEM_DEFAULT = qos_profile_system_default
    SENSOR_DATA = qos_profile_sensor_data
    SERVICES_DEFAULT = qos_profile_services_default
    PARAMETERS = qos_profile_parameters
    PARAMETER_EVENTS = qos_profile_parameter_events
    ACTION_STATUS_DEFAULT = qos_profile_action_status_default
    BEST_AVAILABLE = qos_profile_best_available

    @classmethod
    def short_keys(cls) -> list[str]:
        """Keys in lower case."""
        return [key.lower() for key in cls.__members__]

    @classmethod
    def get_from_short_key(cls, name: str) -> QoSProfile:
        """Profile of a key in any case."""
        profile: QoSProfile = cls[name.upper()].value
        return profile
