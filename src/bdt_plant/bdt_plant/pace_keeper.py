"""Holds a plant in lockstep back until its next measurement is due on the wall clock."""

import time
from collections.abc import Callable

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from bdt_plant.pace import Pace

PERIOD = 0.001
"""Wall time [s] between two looks whether simulated time may go on."""


class PaceKeeper:
    """Asks the pace before each measurement, and calls back when one that was held back is due.

    Parameters
    ----------
    node : rclpy.node.Node
        The plant.
    pace : Pace
        The pace of simulated time.
    proceed : callable
        Called when simulated time may go on.

    Attributes
    ----------
    is_holding : bool
        Whether the next measurement waits for the wall clock, or for a user.
    """

    def __init__(self, node: Node, pace: Pace, proceed: Callable[[], None]) -> None:
        self._pace, self._proceed = pace, proceed
        self._time = 0.0
        self.is_holding = False
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = node.create_timer(PERIOD, self._look, clock=steady)
        self._timer.cancel()

    def may_proceed(self, simulated_time: float) -> bool:
        """Tell whether the measurement of a simulated time [s] may be published now."""
        self._time = simulated_time
        was_holding = self.is_holding
        self.is_holding = not self._pace.is_due(simulated_time, time.monotonic())
        if self.is_holding and not was_holding:
            self._timer.reset()
        return not self.is_holding

    def _look(self) -> None:
        if self._pace.is_due(self._time, time.monotonic()):
            self._timer.cancel()
            self.is_holding = False
            self._proceed()
