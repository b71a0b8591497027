"""Profiles of quality of service: a value for each policy of an endpoint."""

import warnings
from collections.abc import Callable
from enum import Enum
from typing import Any, ClassVar, Final, Generic, TypeVar, overload

from embedded_ros.duration import Duration, Infinite
from embedded_ros.qos_policies import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    ReliabilityPolicy,
)

__all__ = [
    "DeadlineBestAvailable",
    "InvalidQoSProfileException",
    "LivelinessLeaseDurationeBestAvailable",
    "QoSPresetProfiles",
    "QoSProfile",
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

_T = TypeVar("_T")
# In the order in which a profile prints them.
_POLICIES: Final = (
    "history",
    "depth",
    "reliability",
    "durability",
    "lifespan",
    "deadline",
    "liveliness",
    "liveliness_lease_duration",
    "avoid_ros_namespace_conventions",
)


class InvalidQoSProfileException(Exception):
    """A profile lacks a setting that it needs."""

    def __init__(self, *args: object) -> None:
        super().__init__("Invalid QoSProfile", *args)


class _Policy(Generic[_T]):
    """An attribute of profiles that accepts values of one type.

    Parameters
    ----------
    accepted : type
        ``AssertionError`` for values of any other.
    default : object
    convert : callable, optional
        Makes what is stored; ``ValueError`` for numbers that no enumerator has.
    """

    def __init__(
        self, accepted: type, default: _T, convert: Callable[[Any], _T] | None = None
    ) -> None:
        self._accepted = accepted
        self._convert = convert
        self.default = default

    def __set_name__(self, owner: type["QoSProfile"], name: str) -> None:
        self._name = name
        self._slot = f"_{name}"
        owner.policies[name] = self

    @overload
    def __get__(self, profile: None, owner: type) -> "_Policy[_T]": ...
    @overload
    def __get__(self, profile: "QoSProfile", owner: type) -> _T: ...
    def __get__(self, profile: "QoSProfile | None", owner: type) -> "_T | _Policy[_T]":
        if profile is None:
            return self
        value: _T = getattr(profile, self._slot)
        return value

    def __set__(self, profile: "QoSProfile", value: Any) -> None:
        assert isinstance(value, self._accepted), f"{self._name}: {value!r}"
        setattr(profile, self._slot, value if self._convert is None else self._convert(value))


class _Depth(_Policy[int]):
    """Number of samples; keep-last of none makes no sense."""

    def __set__(self, profile: "QoSProfile", value: Any) -> None:
        super().__set__(profile, value)
        if value == 0 and profile.history is HistoryPolicy.KEEP_LAST:
            warnings.warn(
                "A zero depth with KEEP_LAST doesn't make sense; no data could be stored. "
                "This will be interpreted as SYSTEM_DEFAULT",
                stacklevel=3,
            )


class QoSProfile:
    """The policies of an endpoint.

    Parameters
    ----------
    history : HistoryPolicy
        How many samples are kept. Keep-last if only `depth` is given.
    depth : int
        Number of samples that keep-last keeps.
    reliability : ReliabilityPolicy
        Whether lost samples are sent again; reliable by default.
    durability : DurabilityPolicy
        Whether late joiners get earlier samples; volatile by default.
    lifespan : Duration
        Age at which a sample expires; zero: unspecified.
    deadline : Duration
        Longest time between samples; zero: unspecified.
    liveliness : LivelinessPolicy
        Who asserts that a publisher lives.
    liveliness_lease_duration : Duration
        Time after which a publisher that asserts nothing is taken for dead; zero: unspecified.
    avoid_ros_namespace_conventions : bool
        Whether the DDS topic lacks the prefix ``rt``.

    Raises
    ------
    InvalidQoSProfileException
        If neither `history` nor `depth` is given, or keep-last without a depth.
    AssertionError
        If there is no such policy or a value is of another type.
    """

    # No attribute but the policies: a misspelled one is an error. Programs go by these names.
    __slots__ = tuple(f"_{name}" for name in _POLICIES)

    #: Policies by name.
    policies: ClassVar[dict[str, _Policy[Any]]] = {}

    history = _Policy(int, HistoryPolicy.KEEP_LAST, HistoryPolicy)
    depth = _Depth(int, 10)
    reliability = _Policy(int, ReliabilityPolicy.RELIABLE, ReliabilityPolicy)
    durability = _Policy(int, DurabilityPolicy.VOLATILE, DurabilityPolicy)
    lifespan = _Policy(Duration, Duration())
    deadline = _Policy(Duration, Duration())
    liveliness = _Policy(int, LivelinessPolicy.SYSTEM_DEFAULT, LivelinessPolicy)
    liveliness_lease_duration = _Policy(Duration, Duration())
    avoid_ros_namespace_conventions = _Policy(bool, False)

    def __init__(self, **kwargs: Any) -> None:
        assert kwargs.keys() <= self.policies.keys(), (
            f"Invalid arguments passed to constructor: {kwargs.keys()!r}"
        )
        if not kwargs.keys() & {"history", "depth"}:
            raise InvalidQoSProfileException("History and/or depth settings are required.")
        for name in _POLICIES:
            setattr(self, name, kwargs.get(name, self.policies[name].default))
        if "depth" not in kwargs and self.history is HistoryPolicy.KEEP_LAST:
            raise InvalidQoSProfileException("History set to KEEP_LAST without a depth setting.")

    def _values(self) -> list[Any]:
        return [getattr(self, name) for name in _POLICIES]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, QoSProfile) and self._values() == other._values()

    __hash__ = None  # type: ignore[assignment]

    def __str__(self) -> str:
        pairs = map("=".join, zip(_POLICIES, map(str, self._values()), strict=True))
        return f"{type(self).__name__}({', '.join(pairs)})"


# Of a duration: "as long as all peers need". The misspelling is part of the interface.
DeadlineBestAvailable: Final = Duration(nanoseconds=Infinite.nanoseconds - 1)
LivelinessLeaseDurationeBestAvailable: Final = DeadlineBestAvailable


def _keep_last(depth: int, **policies: Any) -> QoSProfile:
    return QoSProfile(depth=depth, **policies)


def _in_all(name: str) -> dict[str, Any]:
    """The value of one name for all policies that leave the choice to somebody else."""
    return {
        policy: enumeration[name]
        for policy, enumeration in (
            ("reliability", ReliabilityPolicy),
            ("durability", DurabilityPolicy),
            ("liveliness", LivelinessPolicy),
        )
    }


qos_profile_unknown: Final = QoSProfile(
    history=HistoryPolicy.UNKNOWN, depth=0, **_in_all("UNKNOWN")
)
qos_profile_system_default: Final = QoSProfile(
    history=HistoryPolicy.SYSTEM_DEFAULT, depth=0, **_in_all("SYSTEM_DEFAULT")
)
qos_profile_best_available: Final = _keep_last(
    10,
    **_in_all("BEST_AVAILABLE"),
    deadline=DeadlineBestAvailable,
    liveliness_lease_duration=LivelinessLeaseDurationeBestAvailable,
)
qos_profile_default: Final = _keep_last(10)
qos_profile_services_default: Final = _keep_last(10)
qos_profile_sensor_data: Final = _keep_last(5, reliability=ReliabilityPolicy.BEST_EFFORT)
qos_profile_parameters: Final = _keep_last(1000)
qos_profile_parameter_events: Final = _keep_last(1000)
qos_profile_action_status_default: Final = _keep_last(
    1, durability=DurabilityPolicy.TRANSIENT_LOCAL
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
        """Names in lower case, of aliases too."""
        return list(map(str.lower, cls.__members__))

    @classmethod
    def get_from_short_key(cls, name: str) -> QoSProfile:
        """Profile of a name in any case; ``KeyError`` if there is none."""
        preset: QoSProfile = cls.__members__[name.upper()].value
        return preset
