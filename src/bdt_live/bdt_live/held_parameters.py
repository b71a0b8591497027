"""The parameters that nodes have told of, as events that say it once more."""

from rcl_interfaces.msg import Parameter, ParameterEvent
from rclpy.serialization import deserialize_message, serialize_message

from bdt_bags.writing.topic_metadata import SerializedMessage


class HeldParameters:
    """Values of parameters that hold on when the events that told them are forgotten."""

    def __init__(self) -> None:
        self._values: dict[str, dict[str, Parameter]] = {}
        self._events: dict[str, tuple[ParameterEvent, SerializedMessage]] = {}

    def take(self, message: SerializedMessage) -> None:
        """Take an event that is forgotten."""
        event = deserialize_message(message.data, ParameterEvent)
        values = self._values.setdefault(event.node, {})
        values |= {each.name: each for each in (*event.new_parameters, *event.changed_parameters)}
        for each in event.deleted_parameters:
            values.pop(each.name, None)
        self._events[event.node] = event, message

    def messages(self) -> list[SerializedMessage]:
        """Return an event for each node that declares all parameters with their last values."""
        return [
            message._replace(
                data=serialize_message(
                    ParameterEvent(
                        stamp=event.stamp, node=node, new_parameters=[*self._values[node].values()]
                    )
                )
            )
            for node, (event, message) in self._events.items()
        ]
