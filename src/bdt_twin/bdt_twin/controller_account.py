"""What the controller says of itself: its diagnostics, and its parameters when it is asked."""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.parameter_client import AsyncParameterClient
from rclpy.task import Future

from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import DEAD_ZONE_PARAMETER, DIAGNOSTICS
from bdt_twin.dead_zone_watch import full_name

SET_BY = "dead_zone_set_by"
START_UP = "start-up"
BY_SERVICE = "parameter service"


class Account(NamedTuple):
    """What a controller has, and how it came by its dead zone.

    Attributes
    ----------
    set_by : str
        ``start-up`` or ``parameter service``.
    values : dict of str to float
        Values of those of the parameters that it has.
    """

    set_by: str
    values: dict[str, float]


class ControllerAccount:
    """Asks a controller for its parameters when its diagnostics give reason to.

    Diagnostics may be some seconds old when they are taken; an answer is not.

    Parameters
    ----------
    node : rclpy.node.Node
        The twin.
    controller : str
        Name of the controller's node.
    timeout : float
        Wall time [s] after which a question without an answer is dropped.
    names : sequence of str
        Parameters to ask for; the dead zone is one of them.
    is_in_doubt : callable
        Called with `dead_zone_set_by` of the diagnostics: whether to ask.
    take : callable
        Called with the account that the controller has given.
    """

    def __init__(
        self,
        node: Node,
        controller: str,
        timeout: float,
        names: Sequence[str],
        is_in_doubt: Callable[[str], bool],
        take: Callable[[Account], object],
    ) -> None:
        self._names = list(names)
        self._is_in_doubt, self._take = is_in_doubt, take
        self._controller = full_name(node, controller)
        self._client = AsyncParameterClient(node, controller)
        self._answer: Future[GetParameters.Response] | None = None
        # Made once: rclpy never forgets quite all of a timer that was destroyed.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._deadline = node.create_timer(timeout, self._forget, clock=steady, autostart=False)
        node.create_subscription(
            DiagnosticArray, DIAGNOSTICS.name, self._hear, qos_profile(DIAGNOSTICS)
        )

    def close(self) -> None:
        """Take no answer any more: the executor may still have one when the node is gone."""
        self._cancel_answer()

    def _hear(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name != self._controller:
                continue
            said = {each.key: each.value for each in status.values}
            set_by = said.get(SET_BY)
            if set_by in (START_UP, BY_SERVICE) and self._is_in_doubt(set_by):
                self._ask(set_by)

    def _ask(self, set_by: str) -> None:
        if self._answer is not None or not self._client.services_are_ready():
            return
        self._answer = self._client.get_parameters(self._names)
        self._answer.add_done_callback(lambda answer: self._take_answer(set_by, answer))
        self._deadline.reset()

    def _take_answer(self, set_by: str, answer: "Future[GetParameters.Response]") -> None:
        if answer is not self._answer or answer.cancelled():
            return
        self._forget()
        response = answer.result()
        if response is None or len(response.values) != len(self._names):
            return
        values = {
            name: value.double_value
            for name, value in zip(self._names, response.values, strict=True)
            if _is_number(value)
        }
        if DEAD_ZONE_PARAMETER in values and all(map(math.isfinite, values.values())):
            self._take(Account(set_by, values))

    def _forget(self) -> None:
        self._cancel_answer()
        self._deadline.cancel()

    def _cancel_answer(self) -> None:
        answer, self._answer = self._answer, None
        if answer is not None and not answer.done():
            answer.cancel()


def _is_number(value: ParameterValue) -> bool:
    return bool(value.type == ParameterType.PARAMETER_DOUBLE)
