"""The parameters of the nodes of a loop: described, watched and set for the page."""

import math
import time
from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterDescriptor, ParameterEvent
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient

from bdt_live.page_requests import ParameterValue
from bdt_live.parameter_controls import Description, control_of
from bdt_msgs_py.command_errors import printable

LATE = 2.0
"""Wall time [s] after which a node has not answered."""

Answer = Callable[[str | None], None]


class RemoteParameters:
    """Parameters of one node.

    Nothing here waits: a node that is not there, or does not answer, has no controls.

    Parameters
    ----------
    node : rclpy.node.Node
        Node that asks.
    name : str
        Node that is asked.
    tell : callable
        Called with a message for the page.

    Attributes
    ----------
    values : dict
        Values in force by name.
    """

    def __init__(self, node: Node, name: str, tell: Callable[[dict[str, Any]], None]) -> None:
        self._name, self._tell = name, tell
        self._full_name = f"{node.get_namespace().rstrip('/')}/{name}"
        self._client = AsyncParameterClient(node, name)
        self._descriptions: dict[str, Description] = {}
        self._is_asking = False
        self._is_there = False
        self._unanswered: dict[int, tuple[float, Answer]] = {}
        self._asked = 0
        self.values: dict[str, Any] = {}

    def look(self) -> None:
        """Ask a node that has come for its parameters; give up on one that does not answer."""
        for number, (due, answer) in list(self._unanswered.items()):
            if time.monotonic() > due:
                del self._unanswered[number]
                answer(f"{self._name} has not answered within {LATE:g} s")
        is_there = self._client.services_are_ready()
        if self._is_there and not is_there:
            self._descriptions.clear()
            self._is_asking = False
            self.tell()
        self._is_there = is_there
        if is_there and not self._descriptions and not self._is_asking:
            self._is_asking = True
            self._client.list_parameters(callback=self._take_names)

    def tell(self) -> None:
        """Tell the page all controls of the node: none while it is not there."""
        controls = [
            control_of(described, self.values[name])
            for name, described in self._descriptions.items()
            if name in self.values
        ]
        self._tell({"type": "parameters", "node": self._name, "controls": controls})

    def take_event(self, event: ParameterEvent) -> None:
        """Take what has changed, whoever has changed it."""
        if event.node != self._full_name:
            return
        changed = {}
        for each in (*event.new_parameters, *event.changed_parameters):
            changed[each.name] = self.values[each.name] = _plain(each.value)
        if changed and self._descriptions:
            self._tell({"type": "values", "node": self._name, "values": changed})

    def set(self, values: dict[str, ParameterValue], answer: Answer) -> None:
        """Set parameters, all or none.

        Parameters
        ----------
        values : dict
            By name; an integer stands for a float where the parameter is one.
        answer : callable
            Called with the node's reason if it refuses, with None once they are set.
        """
        if not self._is_there:
            answer(f"{self._name} is not there")
            return
        asked = [Parameter(name, value=self._converted(name, x)) for name, x in values.items()]
        self._asked += 1
        number = self._asked
        self._unanswered[number] = time.monotonic() + LATE, answer

        def take_answer(future: Any) -> None:
            result = future.result().result
            if self._unanswered.pop(number, None) is not None:
                answer(None if result.successful else printable(result.reason) or "refused")

        self._client.set_parameters_atomically(asked, callback=take_answer)

    @property
    def reconfigurable(self) -> list[str]:
        """Names of the parameters that may change while the node runs."""
        return [name for name, each in self._descriptions.items() if not each.read_only]

    def _converted(self, name: str, value: ParameterValue) -> ParameterValue:
        is_whole = isinstance(value, int) and not isinstance(value, bool)
        return float(value) if is_whole and isinstance(self.values.get(name), float) else value

    def _take_names(self, future: Any) -> None:
        names = sorted(future.result().result.names)

        def take_values(got: Any) -> None:
            self.values = dict(zip(names, map(_plain, got.result().values), strict=False))
            self._is_asking = False
            self.tell()

        def take_descriptions(described: Any) -> None:
            self._descriptions = {
                each.name: _described(each) for each in described.result().descriptors
            }
            self._client.get_parameters(names, callback=take_values)

        self._client.describe_parameters(names, callback=take_descriptions)


def _described(descriptor: ParameterDescriptor) -> Description:
    ranges = [*descriptor.floating_point_range, *descriptor.integer_range]
    low, high, step = (None, None, None)
    if ranges:
        low, high, step = ranges[0].from_value, ranges[0].to_value, ranges[0].step or None
    return Description(
        descriptor.name,
        printable(descriptor.description),
        printable(descriptor.additional_constraints),
        bool(descriptor.read_only),
        low,
        high,
        step,
    )


def _plain(value: Any) -> Any:
    plain = Parameter.from_parameter_msg(ParameterMessage(value=value)).value
    if isinstance(plain, float) and not math.isfinite(plain):
        return None
    return plain if isinstance(plain, (bool, int, float, str)) or plain is None else list(plain)
