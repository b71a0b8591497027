"""Simulated time from outside, checked before the clocks of a node take it.

rclpy subscribes to ``/clock`` by itself and lets an exception about a message that is no time
leave the executor, which ends the node. Here its callback gets only what is a time and continues
what came before.
"""

import time
from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock

from bdt_msgs_py.message_checks import check_clock
from bdt_msgs_py.node_parameters import accepted, rejected
from bdt_msgs_py.rejection import MessageRejectedError, RejectedMessages
from bdt_msgs_py.time_sequence import TimeSequence
from bdt_msgs_py.topics import CLOCK

LARGEST_STEP = 2_000_000_000
"""Simulated time [ns] that may pass between two messages: a plant in lockstep is ahead by less."""

CONFIRMATIONS = 3
"""Messages in a row that make a clock which has gone elsewhere."""

USE_SIM_TIME = "use_sim_time"


def clock_sequence() -> TimeSequence:
    """Return what tells the times of ``/clock`` from strays."""
    return TimeSequence(LARGEST_STEP, CONFIRMATIONS)


class ClockCheck:
    """Stands between ``/clock`` and the clocks of a node, whenever simulated time is switched on.

    Parameters
    ----------
    node : rclpy.node.Node
        Node whose clocks are set by rclpy.
    messages : RejectedMessages
        Counts what is rejected.
    """

    def __init__(self, node: Node, messages: RejectedMessages) -> None:
        self._node, self._messages = node, messages
        self._checked: set[int] = set()
        self._insert()
        node.add_post_set_parameters_callback(self._follow_parameter)

    def _follow_parameter(self, changes: list[Parameter]) -> None:
        if any(change.name == USE_SIM_TIME for change in changes):
            self._checked.clear()
            self._insert()

    def _insert(self) -> None:
        for subscription in self._node.subscriptions:
            # One that takes bytes as they are belongs to a recorder, which obeys nothing.
            is_clock = subscription.msg_type is Clock and not subscription.raw
            if is_clock and id(subscription) not in self._checked:
                self._checked.add(id(subscription))
                subscription.callback = self._checking(subscription.callback, clock_sequence())

    def _checking(
        self, set_clocks: Callable[[Any], object], sequence: TimeSequence
    ) -> Callable[[Clock], None]:
        def take(message: Clock) -> None:
            try:
                sequence.check(check_clock(message), time.monotonic())
            except MessageRejectedError as error:
                self._messages.count(CLOCK, error)
                return
            set_clocks(message)

        return take


def keep_wall_time(node: Node, reason: str) -> None:
    """Refuse that ``use_sim_time`` is changed while a node runs.

    Parameters
    ----------
    node : rclpy.node.Node
        The node.
    reason : str
        Why, as the answer to the request says.
    """

    def decide(changes: list[Parameter]) -> Any:
        for change in changes:
            current = node.get_parameter(USE_SIM_TIME).value
            if change.name == USE_SIM_TIME and change.value != current:
                return rejected(
                    f"{USE_SIM_TIME} cannot be set while {node.get_name()} runs: {reason}"
                )
        return accepted()

    node.add_on_set_parameters_callback(decide)
