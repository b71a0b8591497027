"""Timers and triggers: the part of :class:`rclpy.node.Node` that makes what only it sees."""

from collections.abc import Callable, Iterator
from typing import Any

from embedded_ros.duration import NANOSECONDS_PER_SECOND
from embedded_ros.entity_registry import Kind
from rclpy._node_endpoints import NodeEndpoints
from rclpy.callback_groups import (
    CallbackGroup,
    ReentrantCallbackGroup,
)
from rclpy.clock import Clock
from rclpy.guard_condition import GuardCondition
from rclpy.timer import Rate, Timer

__all__ = ["NodeEntities"]


class NodeEntities(NodeEndpoints):
    """Timers, rates and guard conditions, besides what the network sees."""

    def get_clock(self) -> Clock:
        """Clock of the node."""
        raise NotImplementedError

    def __init__(self) -> None:
        super().__init__()
        self.__group_of_rates = ReentrantCallbackGroup()

    @property
    def timers(self) -> Iterator[Timer]:
        """Timers of the node."""
        return self._embedded.registry.of(Kind.TIMER)

    @property
    def guards(self) -> Iterator[GuardCondition]:
        """Guard conditions of the node."""
        return self._embedded.registry.of(Kind.GUARD_CONDITION)

    # ------------------------------------------------------------------ timers and triggers

    def create_timer(
        self,
        timer_period_sec: float,
        callback: Callable[[], Any] | None,
        callback_group: CallbackGroup | None = None,
        clock: Clock | None = None,
        autostart: bool = True,
    ) -> Timer:
        """Make a timer.

        Parameters
        ----------
        timer_period_sec : float
        callback : callable
        callback_group : CallbackGroup, optional
        clock : Clock, optional
            The node's clock by default, which may show simulated time.
        autostart : bool
            If false the timer starts with :meth:`.Timer.reset`.
        """
        period = int(float(timer_period_sec) * NANOSECONDS_PER_SECOND)
        group = callback_group or self.default_callback_group
        timer = Timer(
            callback,
            group,
            period,
            clock or self.get_clock(),
            context=self.context,
            autostart=autostart,
        )
        timer._alarm.on_change = self._embedded.on_change
        self._embedded.add(Kind.TIMER, timer, group)
        return timer

    def create_rate(self, frequency: float, clock: Clock | None = None) -> Rate:
        """Make a rate of a frequency in hertz."""
        if frequency > 0:
            timer = self.create_timer(1.0 / frequency, None, self.__group_of_rates, clock)
            return Rate(timer, context=self.context)
        raise ValueError("frequency must be > 0")

    def create_guard_condition(
        self, callback: Callable[[], Any], callback_group: CallbackGroup | None = None
    ) -> GuardCondition:
        """Make a trigger for a callback."""
        group = callback_group or self.default_callback_group
        guard = GuardCondition(callback, group, self.context)
        self._embedded.add(Kind.GUARD_CONDITION, guard, group)
        return guard

    def destroy_timer(self, timer: Timer) -> bool:
        """Destroy a timer; False if it is not one of this node."""
        return self._embedded.remove(Kind.TIMER, timer)

    def destroy_guard_condition(self, guard: GuardCondition) -> bool:
        """Destroy a guard condition; False if it is not one of this node."""
        return self._embedded.remove(Kind.GUARD_CONDITION, guard)

    def destroy_rate(self, rate: Rate) -> bool:
        """Destroy a rate; False if it is not one of this node."""
        rate.destroy()
        return self.destroy_timer(rate._ticker)
