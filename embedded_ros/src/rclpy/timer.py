"""Timers and rates."""

import threading
from collections.abc import Awaitable, Callable
from typing import Any

from embedded_ros.alarm import Alarm, AlarmState
from embedded_ros.errors import InvalidHandle, RCLError, ROSInterruptException
from embedded_ros.futures import TaskRunner
from rclpy.callback_groups import CallbackGroup
from rclpy.clock import Clock
from rclpy.context import Context
from rclpy.utilities import get_default_context

__all__ = ["Rate", "Timer"]

TimerCallback = Callable[[], "Awaitable[Any] | Any"]


def _nobody() -> None:
    """Wake nobody."""


class Timer:
    """Calls back periodically; made by :meth:`rclpy.node.Node.create_timer`.

    Calls that were missed are left out: the next one is at the next multiple of the period.
    Used after :meth:`destroy` it raises :class:`InvalidHandle`.
    """

    def __init__(
        self,
        callback: TimerCallback | None,
        callback_group: CallbackGroup | None,
        timer_period_ns: int,
        clock: Clock,
        *,
        context: Context | None = None,
        autostart: bool = True,
    ) -> None:
        if timer_period_ns < 0:
            raise RCLError("failed to create timer: timer period must be non-negative")
        self.callback = callback
        self.callback_group = callback_group
        self._of_context = context or get_default_context()
        self._follows = clock
        self._alarm = Alarm(clock._timeline, int(timer_period_ns), _nobody, running=autostart)
        #: What an executor asks for.
        self._due_in = self._alarm.due_in

    def _take(self, _runner: TaskRunner | None = None) -> tuple[TimerCallback, tuple[()]] | None:
        if self._alarm.ring() and self.callback is not None:
            return self.callback, ()
        return None

    def _usable(self) -> Alarm:
        if self._alarm.state is AlarmState.CLOSED:
            raise InvalidHandle
        return self._alarm

    @property
    def handle(self) -> Alarm:
        """What is below the timer."""
        return self._alarm

    def destroy(self) -> None:
        """Stop for ever. Again is fine."""
        self._alarm.close()

    @property
    def clock(self) -> Clock:
        """Clock that the timer follows."""
        return self._follows

    @property
    def timer_period_ns(self) -> int:
        """Period in nanoseconds; a new one counts from the next call on."""
        return self._usable().period

    @timer_period_ns.setter
    def timer_period_ns(self, value: int) -> None:
        self._usable().period = int(value)

    def is_ready(self) -> bool:
        """Tell whether the callback is due."""
        alarm = self._usable()
        return alarm.state is AlarmState.RUNNING and alarm.time_left() <= 0

    def is_canceled(self) -> bool:
        """Tell whether the timer is canceled."""
        return self._usable().state is AlarmState.CANCELED

    def cancel(self) -> None:
        """Stop until :meth:`reset`."""
        self._usable().cancel()

    def reset(self) -> None:
        """Start anew: the next call is a period from now."""
        self._usable().restart()

    def time_since_last_call(self) -> int:
        """Nanoseconds since the last call, or since the timer was made."""
        return self._usable().since_ring()

    def time_until_next_call(self) -> int | None:
        """Nanoseconds until the next call, negative if it is overdue; None if canceled."""
        alarm = self._usable()
        return None if alarm.state is AlarmState.CANCELED else alarm.time_left()


class Rate:
    """Sleeps in step with a timer; made by :meth:`rclpy.node.Node.create_rate`.

    An executor must spin the node in another thread.
    """

    def __init__(self, timer: Timer, *, context: Context) -> None:
        self._ticker = timer
        self._bell = threading.Condition()
        # How often the timer has called, and of how many calls a sleeper knows: one that nobody
        # slept for ends the next sleep at once.
        self._ticks = 0
        self._known = 0
        self._ending: type[Exception] | None = None
        self._within = context
        timer.callback = self._tick
        context.on_shutdown(self.interrupt)
        if context.handle is not None:
            context.handle.register(self)

    def _tick(self) -> None:
        with self._bell:
            self._ticks += 1
            self._bell.notify_all()

    def interrupt(self) -> None:
        """Wake the sleepers if the context has been shut down."""
        if not self._within.ok():
            self._end(ROSInterruptException)

    def destroy(self) -> None:
        """Wake the sleepers and sleep no more."""
        self._end(RuntimeError)

    def _end(self, reason: type[Exception]) -> None:
        with self._bell:
            if self._ending is not ROSInterruptException:
                self._ending = reason
            self._bell.notify_all()

    def sleep(self) -> None:
        """Sleep until the timer's next call.

        Raises
        ------
        ROSInterruptException
            If the context is shut down.
        RuntimeError
            If the rate is destroyed.
        InvalidHandle
            If the timer is destroyed.
        """
        with self._bell:
            if self._ending is RuntimeError:
                raise RuntimeError("Rate cannot sleep because it has been destroyed")
            if self._ending is None and self._ticker.handle.state is AlarmState.CLOSED:
                self._ending = RuntimeError
                raise InvalidHandle("Rate cannot sleep because the timer has been destroyed")
            known = self._known
            self._bell.wait_for(lambda: self._ticks > known or self._ending is not None)
            self._known = self._ticks
            if self._ending is ROSInterruptException:
                raise ROSInterruptException
