"""The errors that rclpy's C extension raises, under their names there."""

__all__ = [
    "InvalidHandle",
    "NodeNameNonExistentError",
    "RCLError",
    "RCLInvalidROSArgsError",
    "RMWError",
    "UnknownROSArgsError",
    "UnsupportedEventTypeError",
]


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


class InvalidHandle(RuntimeError):
    """An entity is used after its destruction."""

    def __init__(
        self, text: str = "cannot use Destroyable because destruction was requested"
    ) -> None:
        super().__init__(text)


class UnsupportedEventTypeError(RCLError):
    """An event that the middleware does not know."""
