"""Timers and rates."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from embedded_ros.errors import RCLError
from rclpy.callback_groups import CallbackGroup
from rclpy.clock import Clock, ClockChange, JumpThreshold, TimeJump
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.exceptions import InvalidHandle, ROSInterruptException
from rclpy.utilities import get_default_context

if TYPE_CHECKING:
    from collections.abc import Awaitable

__all__ = ["Rate", "Timer"]

TimerCallback = Callable[[], "Awaitable[Any] | Any"]


class Timer:
    """Calls back periodically; made by :meth:`rclpy.node.Node.create_timer`.

    Calls that were missed are left out: the next one is at the next multiple of the period.
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
        self._context = get_default_context() if context is None else context
        self._clock = clock
        self._period = int(timer_period_ns)
        self._last_call = clock._nanoseconds()
        self._next_call = self._last_call + self._period
        self._canceled = not autostart
        self._destroyed = False
        self._credit = 0
        self.callback = callback
        self.callback_group = callback_group
        #: Wakes the executor that waits for this timer; set by the node.
        self._wake: Callable[[], None] = _nobody
        self._jump_handle = None
        if clock.clock_type is ClockType.ROS_TIME:
            self._jump_handle = clock.create_jump_callback(
                JumpThreshold(
                    min_forward=Duration(nanoseconds=1), min_backward=Duration(nanoseconds=-1)
                ),
                pre_callback=self._before_jump,
                post_callback=self._after_jump,
            )

    def _before_jump(self) -> None:
        # On a change of the source the timer keeps what is left of its period. The clock still
        # shows the old time here; that of an ordinary jump is not used.
        now = self._clock._nanoseconds()
        self._credit = self._next_call - now if now else 0

    def _after_jump(self, jump: TimeJump) -> None:
        now = self._clock._nanoseconds()
        if jump.clock_change in (
            ClockChange.ROS_TIME_ACTIVATED,
            ClockChange.ROS_TIME_DEACTIVATED,
        ):
            if now and self._credit:
                self._next_call = now - self._credit + self._period
                self._last_call = now - self._credit
            self._wake()
        elif self._next_call <= now:
            self._wake()
        elif now < self._last_call:
            self._next_call = now + self._period
            self._last_call = now

    def _check(self) -> None:
        if self._destroyed:
            raise InvalidHandle

    def _take(self) -> TimerCallback | None:
        """Reckon the next call and return the callback; None if the time has not come."""
        now = self._clock._nanoseconds()
        if self._destroyed or self._canceled or now < self._next_call:
            return None
        self._last_call = now
        self._next_call += self._period
        if self._next_call < now:
            if self._period:
                self._next_call += (1 + (now - self._next_call) // self._period) * self._period
            else:
                self._next_call = now
        return self.callback

    def _nanoseconds_left(self) -> int | None:
        """Time until the next call if the clock runs by itself; else 0 if due or None."""
        if self._destroyed or self._canceled:
            return None
        left = max(0, self._next_call - self._clock._nanoseconds())
        return left if left == 0 or self._clock._runs_by_itself() else None

    @property
    def handle(self) -> Timer | None:
        """None once the timer is destroyed."""
        return None if self._destroyed else self

    def destroy(self) -> None:
        """Stop for ever. Again is fine."""
        self._destroyed = True
        if self._jump_handle is not None:
            self._jump_handle.unregister()
            self._jump_handle = None

    @property
    def clock(self) -> Clock:
        """Clock that the timer follows."""
        return self._clock

    @property
    def timer_period_ns(self) -> int:
        """Period in nanoseconds; a new one counts from the next call on."""
        self._check()
        return self._period

    @timer_period_ns.setter
    def timer_period_ns(self, value: int) -> None:
        self._check()
        self._period = int(value)

    def is_ready(self) -> bool:
        """Tell whether the callback is due."""
        self._check()
        return not self._canceled and self._next_call <= self._clock._nanoseconds()

    def is_canceled(self) -> bool:
        """Tell whether the timer is canceled."""
        self._check()
        return self._canceled

    def cancel(self) -> None:
        """Stop until :meth:`reset`."""
        self._check()
        self._canceled = True

    def reset(self) -> None:
        """Start anew: the next call is a period from now."""
        self._check()
        self._canceled = False
        self._next_call = self._clock._nanoseconds() + self._period
        self._wake()

    def time_since_last_call(self) -> int:
        """Nanoseconds since the last call, or since the timer was made."""
        self._check()
        return self._clock._nanoseconds() - self._last_call

    def time_until_next_call(self) -> int | None:
        """Nanoseconds until the next call, negative if it is overdue; None if canceled."""
        self._check()
        return None if self._canceled else self._next_call - self._clock._nanoseconds()


def _nobody() -> None:
    """Wake nobody."""


class Rate:
    """Sleeps in step with a timer; made by :meth:`rclpy.node.Node.create_rate`.

    An executor must spin the node in another thread.
    """

    def __init__(self, timer: Timer, *, context: Context) -> None:
        self._timer = timer
        self._is_shutdown = False
        self._is_destroyed = False
        self._event = threading.Event()
        self._lock = threading.Lock()
        self._num_sleepers = 0
        self._timer.callback = self._event.set
        context.on_shutdown(self._on_shutdown)
        if context.handle is not None:
            context.handle.register(self)
        self._context = context

    def interrupt(self) -> None:
        """Wake the sleepers if the context has been shut down."""
        if not self._context.ok():
            self._on_shutdown()

    def _on_shutdown(self) -> None:
        self._is_shutdown = True
        self.destroy()

    def destroy(self) -> None:
        """Wake the sleepers and sleep no more."""
        self._is_destroyed = True
        self._event.set()

    def sleep(self) -> None:
        """Sleep until the timer's next call.

        Raises
        ------
        ROSInterruptException
            If the context is shut down.
        """
        if self._is_shutdown:
            raise ROSInterruptException
        if self._is_destroyed:
            raise RuntimeError("Rate cannot sleep because it has been destroyed")
        if self._timer.handle is None:
            self.destroy()
            raise InvalidHandle("Rate cannot sleep because the timer has been destroyed")
        with self._lock:
            self._num_sleepers += 1
        try:
            self._event.wait()
        finally:
            with self._lock:
                self._num_sleepers -= 1
                if self._num_sleepers == 0 and not self._is_destroyed:
                    self._event.clear()
        if self._is_shutdown:
            raise ROSInterruptException
