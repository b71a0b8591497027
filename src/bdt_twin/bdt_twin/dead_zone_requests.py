"""Requests to the controller's parameter service: asked, answered, refused or given up."""

import time
from collections.abc import Callable, Iterable
from typing import TypeAlias

from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.task import Future

from bdt_msgs_py.topics import (
    DEAD_ZONE_PARAMETER,
    PARAMETER_EVENTS,
    VOLTAGE_OFFSET_PARAMETER,
)
from bdt_twin.dead_zone_watch import full_name
from bdt_twin.link import Reconfiguration

Response: TypeAlias = SetParameters.Response | SetParametersAtomically.Response

Life: TypeAlias = tuple[int, ...]
"""Identifier of one life of a controller: that of its publisher of parameter events."""

LOOK_PERIOD = 0.05
"""Wall time [s] between two looks for a service that is not there yet."""

NEWCOMER, PATIENCE = 3.0, 0.2
"""Wall time [s] for which a controller is a newcomer, and after which it is asked once more then.

The network forgets a dead one in its own time: until then its service looks ready, before that of
the newcomer is, and what is asked goes nowhere.
"""


class DeadZoneRequests:
    """Sets the controller's dead zone, one request at a time; nothing here waits.

    A voltage offset and gains are set together with the dead zone or not at all. A controller that
    refuses them may be somebody else's, without these parameters: it is asked for the dead zone
    alone.

    Parameters
    ----------
    node : rclpy.node.Node
        Node that asks.
    controller : str
        Name of the controller's node.
    timeout : float
        Wall time [s] after which a request without an answer has failed.
    ended : callable
        Called when a request has ended, whatever its end; with what was asked for if there was no
        answer and it is still wanted.

    Attributes
    ----------
    in_flight : Reconfiguration or None
        What is being asked for.
    accepted, failed : int
        Number of requests.
    refused_offsets : int
        Number of times that the controller refused a voltage offset or gains.
    """

    def __init__(
        self,
        node: Node,
        controller: str,
        timeout: float,
        ended: Callable[[Reconfiguration | None], object],
    ) -> None:
        self._node, self._name, self._ended = node, controller, ended
        self._controller = full_name(node, controller)
        self._client = AsyncParameterClient(node, controller)
        # Made once: rclpy never forgets quite all of a timer that was destroyed.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._deadline = node.create_timer(timeout, self._give_up, clock=steady, autostart=False)
        self._look = node.create_timer(LOOK_PERIOD, self._ask, clock=steady, autostart=False)
        self._answer: Future[Response] | None = None
        self._publishers: set[Life] = set()
        self._asked: set[Life] = set()
        self._informed: set[Life] = set()
        self._asked_at = self._newcomer_until = 0.0
        self._is_there = self._is_dropped = self._is_unseen_informed = False
        self.in_flight: Reconfiguration | None = None
        self.accepted = self.failed = self.refused_offsets = 0

    def send(self, reconfiguration: Reconfiguration) -> None:
        """Ask the controller for a dead zone, and for what goes with it."""
        self.in_flight, self._is_dropped = reconfiguration, False
        self._deadline.reset()
        self._ask()
        self._look_for_service()

    def _look_for_service(self) -> None:
        if self._answer is None:
            self._look.reset()

    def controller_appeared(self) -> bool:
        """Tell whether there is a controller that was not there when this was asked before.

        Every node publishes parameter events, so each of its lives has a publisher of its own.
        """
        found = self._found_publishers()
        if found and self._is_unseen_informed:
            # Should another one have come instead, its diagnostics tell that it knows nothing.
            self._is_unseen_informed = False
            self._informed = found
            self._publishers |= found
        appeared = not found <= self._publishers
        self._publishers |= found
        self._is_there = self._is_there and not appeared
        now = time.monotonic()
        if appeared:
            self._newcomer_until = now + NEWCOMER
        is_overdue = now < self._newcomer_until and now - self._asked_at >= PATIENCE
        if (appeared and not found <= self._asked) or is_overdue:
            self._ask_anew()
        return appeared

    def _ask_anew(self) -> None:
        """Ask once more: whoever was asked is gone, or a second question does it no harm."""
        if self._answer is None or self._is_dropped:
            return
        self._answer.cancel()
        self._answer = None
        self._ask()
        self._look_for_service()

    @property
    def informed(self) -> tuple[str, ...]:
        """Identifiers of the controllers that have what was asked for last."""
        return tuple(sorted(bytes(life).hex() for life in self._informed))

    def note_informed(self, lives: Iterable[str] | None = None) -> None:
        """Note that controllers have what is in force: those of these identifiers, or all."""
        known = {tuple(bytes.fromhex(life)) for life in lives} if lives is not None else None
        self._informed = self._found_publishers() if known is None else known
        self._is_unseen_informed = known is None and not self._informed
        self._publishers |= self._informed

    def drop(self) -> None:
        """Forget a request that waits for the service; one that was sent may still be answered."""
        self._is_dropped = True
        if self._answer is None:
            self._clear()

    def close(self) -> None:
        """Take no answer any more: the executor may still have one when the node is gone."""
        answer, self._answer, self.in_flight = self._answer, None, None
        if answer is not None and not answer.done():
            answer.cancel()

    def forget_offset(self) -> None:
        """Ask for the dead zone alone, as far as nothing was asked for yet."""
        if self.in_flight is not None and self._answer is None:
            self.in_flight = self.in_flight._replace(voltage_offset=None)

    def _forget_extras(self) -> None:
        if self.in_flight is not None:
            self.in_flight = self.in_flight._replace(voltage_offset=None, gains=())

    def _found_publishers(self) -> set[Life]:
        return {
            tuple(one.endpoint_gid)
            for one in self._node.get_publishers_info_by_topic(PARAMETER_EVENTS.name)
            if f"{one.node_namespace.rstrip('/')}/{one.node_name}" == self._controller
        }

    def _ask(self) -> None:
        """Send the request once the service is there: before, it would be lost."""
        wanted = self.in_flight
        if wanted is None or self._answer is not None:
            return
        self._is_there = self._is_there or self._client.services_are_ready()
        if not self._is_there:
            return
        self._asked, self._asked_at = self._found_publishers(), time.monotonic()
        values = {DEAD_ZONE_PARAMETER: wanted.tolerance, **dict(wanted.gains)}
        if wanted.voltage_offset is not None:
            values[VOLTAGE_OFFSET_PARAMETER] = wanted.voltage_offset
        parameters = [
            Parameter(name, Parameter.Type.DOUBLE, value) for name, value in values.items()
        ]
        if len(parameters) == 1:
            self._answer = self._client.set_parameters(parameters)
        else:
            self._answer = self._client.set_parameters_atomically(parameters)
        self._answer.add_done_callback(self._take_answer)

    def _take_answer(self, answer: "Future[Response]") -> None:
        if answer is not self._answer or answer.cancelled():
            return
        result = _result_of(answer.result())
        if result is None:
            return  # not an answer: the timeout will count it
        if self._is_refused_extra(result):
            self._ask_for_dead_zone(result.reason)
            return
        # Whoever has answered knows the dead zone, and needs it no second time for being new.
        self._publishers |= self._asked
        if result.successful:
            self.accepted += 1
            self._informed = self._asked
            # The network may tell of a service before it tells whose the publishers are.
            self._is_unseen_informed = not self._asked
        else:
            self._fail(f"the controller refused the dead zone: {result.reason}")
        self._end()

    def _is_refused_extra(self, result: SetParametersResult) -> bool:
        wanted = self.in_flight
        has_extras = wanted is not None and (
            wanted.voltage_offset is not None or bool(wanted.gains)
        )
        return has_extras and not result.successful and not self._is_dropped

    def _ask_for_dead_zone(self, reason: str) -> None:
        gains = self.in_flight is not None and bool(self.in_flight.gains)
        what = "gains" if gains else "voltage offset"
        self.refused_offsets += 1
        self._node.get_logger().warning(
            f"the controller refused the {what}, and is asked for the dead zone alone: {reason}",
            throttle_duration_sec=60.0,
        )
        self._answer = None
        self._forget_extras()
        self._ask()

    def _give_up(self) -> None:
        if self.in_flight is None:
            return
        if self._answer is not None:
            self._answer.cancel()
        self._is_there = False
        self._fail(f"no answer from {self._name} to a reconfiguration")
        self._end(None if self._is_dropped else self.in_flight)

    def _fail(self, text: str) -> None:
        self.failed += 1
        self._node.get_logger().warning(text, throttle_duration_sec=1.0)

    def _end(self, unanswered: Reconfiguration | None = None) -> None:
        self._clear()
        self._ended(unanswered)

    def _clear(self) -> None:
        self.in_flight = self._answer = None
        self._deadline.cancel()
        self._look.cancel()


def _result_of(response: Response | None) -> SetParametersResult | None:
    """Return whether the request was met; None for a response that does not tell."""
    if isinstance(response, SetParametersAtomically.Response):
        return response.result
    if response is None or len(response.results) != 1:
        return None
    (result,) = response.results
    return result
