"""All errors that callers can catch; their texts are part of the interface.

Two families: those of rcl and rmw, which in ROS 2 come out of compiled code, and those that name
what the caller did wrong.
"""

from typing import Any, ClassVar, Protocol

__all__ = [
    "ConditionReachedException",
    "ExternalShutdownException",
    "InvalidHandle",
    "InvalidNamespaceException",
    "InvalidNodeNameException",
    "InvalidParameterException",
    "InvalidParameterTypeException",
    "InvalidParameterValueException",
    "InvalidServiceNameException",
    "InvalidTopicNameException",
    "NameValidationException",
    "NoTypeSupportImportedException",
    "NodeNameNonExistentError",
    "NotInitializedException",
    "ParameterAlreadyDeclaredException",
    "ParameterException",
    "ParameterImmutableException",
    "ParameterNotDeclaredException",
    "ParameterUninitializedException",
    "RCLError",
    "RCLInvalidROSArgsError",
    "RMWError",
    "ROSInterruptException",
    "ShutdownException",
    "TimeoutException",
    "UnknownROSArgsError",
    "UnsupportedEventTypeError",
]

# ------------------------------------------------------------------------- of rcl and rmw


class RCLError(RuntimeError):
    """An operation of the ROS client library failed."""


class RMWError(RuntimeError):
    """An operation of the middleware failed."""


class RCLInvalidROSArgsError(RCLError):
    """A ROS argument is malformed."""


class UnknownROSArgsError(RuntimeError):
    """There is no such ROS argument; the text is the list of them."""


class NodeNameNonExistentError(RCLError):
    """The graph has no node of this name."""


class UnsupportedEventTypeError(RCLError):
    """An event that the middleware does not know."""


class InvalidHandle(RuntimeError):
    """An entity is used after its destruction."""

    def __init__(
        self, text: str = "cannot use Destroyable because destruction was requested"
    ) -> None:
        super().__init__(text)


# ------------------------------------------------------------------------- of contexts


class NotInitializedException(Exception):
    """The context is not initialized, or it is shut down."""

    def __init__(self, message: str | None = None) -> None:
        text = "rclpy.init() has not been called."
        super().__init__(f"{text} msg:{message}" if message else text)


class ROSInterruptException(Exception):
    """An operation ends because the context shuts down."""

    def __init__(self) -> None:
        super().__init__("rclpy.shutdown() has been called")


# ------------------------------------------------------------------------- of executors


class TimeoutException(Exception):
    """Nothing happened in time."""


class ShutdownException(Exception):
    """The executor is shut down."""


class ExternalShutdownException(Exception):
    """The context was shut down while the executor waited."""


class ConditionReachedException(Exception):
    """The future to wait for is done."""


# ------------------------------------------------------------------------- of types and names


class NoTypeSupportImportedException(Exception):
    """Something is used as a message or service type that is none."""

    def __init__(self) -> None:
        super().__init__("no type_support imported")


class NameValidationException(Exception):
    """A name is invalid; the text shows the name and an arrow below the offending character."""

    def __init__(self, name_type: str, name: str, error_msg: str, invalid_index: int) -> None:
        lines = (
            f"Invalid {name_type}: {error_msg}:",
            f"  '{name}'",
            f"   {'^':>{invalid_index + 1}}",
        )
        super().__init__("\n".join(lines))


class _NamedKindException(NameValidationException):
    """A name of the kind that the class states is invalid."""

    _kind: ClassVar[str]

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__(self._kind, name, error_msg, invalid_index)


class InvalidNamespaceException(_NamedKindException):
    """A namespace is invalid."""

    _kind = "namespace"


class InvalidNodeNameException(_NamedKindException):
    """A node name is invalid."""

    _kind = "node name"


class InvalidTopicNameException(_NamedKindException):
    """A topic name is invalid."""

    _kind = "topic name"


class InvalidServiceNameException(_NamedKindException):
    """A service name is invalid."""

    _kind = "service name"


# ------------------------------------------------------------------------- of parameters


class _TypedValue(Protocol):
    """What a text about a parameter tells of it."""

    @property
    def name(self) -> str: ...

    @property
    def value(self) -> Any: ...

    @property
    def type_(self) -> Any: ...


class ParameterException(Exception):
    """Base of the exceptions about parameters."""

    def __init__(self, error_msg: str, parameters: str | list[str]) -> None:
        super().__init__(f"{error_msg}: {parameters}")


class ParameterNotDeclaredException(ParameterException):
    """An undeclared parameter is used where that is not allowed."""

    def __init__(self, parameters: str | list[str]) -> None:
        super().__init__("Invalid access to undeclared parameter(s)", parameters)


class ParameterAlreadyDeclaredException(ParameterException):
    """A parameter is declared a second time."""

    def __init__(self, parameters: str | list[str]) -> None:
        super().__init__("Parameter(s) already declared", parameters)


class InvalidParameterException(ParameterException):
    """A parameter is declared under an invalid name."""

    def __init__(self, parameter_name: str) -> None:
        super().__init__("Invalid parameter name", parameter_name)


class InvalidParameterTypeException(ParameterException):
    """A declared parameter gets a value of another type."""

    def __init__(self, desired_parameter: _TypedValue, expected_type: str) -> None:
        name, given = desired_parameter.name, desired_parameter.type_.name
        super().__init__(
            f"Trying to set parameter '{name}' to '{desired_parameter.value}' of type '{given}',"
            f" expecting type '{expected_type}'",
            name,
        )


class InvalidParameterValueException(ParameterException):
    """A parameter is rejected by its descriptor or by a callback."""

    def __init__(self, parameter: str, value: Any, reason: str) -> None:
        text = f"Invalid parameter value ({value}) for parameter. Reason: {reason}"
        super().__init__(text, parameter)


class ParameterImmutableException(ParameterException):
    """A read-only parameter is modified."""

    def __init__(self, parameter_name: str) -> None:
        super().__init__("Attempted to modify read-only parameter", parameter_name)


class ParameterUninitializedException(ParameterException):
    """A parameter that is declared by type is read before it has a value."""

    def __init__(self, parameter_name: str) -> None:
        super().__init__(f"The parameter '{parameter_name}' is not initialized", parameter_name)
