"""Hears from the parameter events of the controller whether the dead zone is still the twin's."""

from collections.abc import Callable

from rcl_interfaces.msg import ParameterEvent, ParameterValue
from rclpy.node import Node

from bdt_msgs_py.message_checks import check_dead_zone
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.rejection import MessageRejectedError
from bdt_msgs_py.topics import (
    DEAD_ZONE_PARAMETER,
    PARAMETER_EVENTS,
    VOLTAGE_OFFSET_PARAMETER,
    Topic,
)
from bdt_twin.dead_zone_in_force import DeadZoneInForce
from bdt_twin.link import Reconfiguration


class DeadZoneWatch:
    """Subscription of the controller's parameter events.

    Parameters
    ----------
    node : rclpy.node.Node
        The twin.
    controller : str
        Name of the controller's node, as the twin's parameter ``controller_node`` has it.
    report : callable
        Called with a line when somebody else has set the dead zone, or what was asked for with it.
    began : callable
        Called when a controller says that it begins.
    reject : callable
        Called with topic and reason for a dead zone that cannot be.

    Attributes
    ----------
    state : DeadZoneInForce
        What is known of the dead zone.
    """

    def __init__(
        self,
        node: Node,
        controller: str,
        report: Callable[[str], object],
        began: Callable[[], object],
        reject: Callable[[Topic, MessageRejectedError], object],
    ) -> None:
        self.state = DeadZoneInForce()
        self._extras: dict[str, DeadZoneInForce] = {}
        self._report, self._began, self._reject = report, began, reject
        self._controller = full_name(node, controller)
        node.create_subscription(
            ParameterEvent, PARAMETER_EVENTS.name, self._take_event, qos_profile(PARAMETER_EVENTS)
        )

    def request(self, wanted: Reconfiguration) -> None:
        """Note what the twin asks for."""
        self.state.request(wanted.tolerance)
        extras = dict(wanted.gains)
        if wanted.voltage_offset is not None:
            extras[VOLTAGE_OFFSET_PARAMETER] = wanted.voltage_offset
        for name, value in extras.items():
            self._extras.setdefault(name, DeadZoneInForce()).request(value)

    def _take_event(self, event: ParameterEvent) -> None:
        if event.node != self._controller:
            return
        for parameters, is_new in ((event.new_parameters, True), (event.changed_parameters, False)):
            for parameter in parameters:
                if parameter.name == DEAD_ZONE_PARAMETER:
                    self._note(parameter.value, is_new)
                    if is_new:
                        self._began()
                elif not is_new and parameter.name in self._extras:
                    self._note_extra(parameter.name, parameter.value.double_value)

    def _note_extra(self, name: str, value: float) -> None:
        if self._extras[name].note(value, is_new=False):
            self._report(f"somebody else has set {name} of {self._controller} to {value:g}")

    def _note(self, parameter: ParameterValue, is_new: bool) -> None:
        try:
            value = check_dead_zone(parameter)
        except MessageRejectedError as error:
            self._reject(PARAMETER_EVENTS, error)
            return
        if self.state.note(value, is_new=is_new):
            self._report(
                f"somebody else has set the dead zone of {self._controller} to {value:g} m"
            )


def full_name(node: Node, controller: str) -> str:
    """Return the controller's name with its namespace, as `node` would reach it.

    Where its parameter service is, remap rules included, there is the controller.
    """
    return node.resolve_service_name(f"{controller}/set_parameters").rpartition("/")[0]
