"""Clocks, simulated time and jumps of it."""

from __future__ import annotations

import threading
import time as _time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

from embedded_ros.time_jumps import ClockChange, JumpThreshold, TimeJump
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.exceptions import NotInitializedException
from rclpy.time import Time
from rclpy.utilities import get_default_context

__all__ = [
    "Clock",
    "ClockChange",
    "ClockType",
    "JumpHandle",
    "JumpThreshold",
    "ROSClock",
    "TimeJump",
]


class JumpHandle:
    """A registered jump callback; a context manager that unregisters it.

    Made by :meth:`Clock.create_jump_callback`.
    """

    def __init__(
        self,
        *,
        clock: Clock,
        threshold: JumpThreshold,
        pre_callback: Callable[[], Any] | None,
        post_callback: Callable[[TimeJump], Any] | None,
    ) -> None:
        if pre_callback is None and post_callback is None:
            raise ValueError("One of pre_callback or post_callback must be callable")
        if pre_callback is not None and not callable(pre_callback):
            raise ValueError("pre_callback must be callable if given")
        if post_callback is not None and not callable(post_callback):
            raise ValueError("post_callback must be callable if given")
        self._clock: Clock | None = clock
        self._threshold = threshold
        self._pre_callback = pre_callback
        self._post_callback = post_callback
        clock._jump_handles.append(self)

    def unregister(self) -> None:
        """Remove the callback. Again is fine."""
        clock, self._clock = self._clock, None
        if clock is not None:
            clock._jump_handles.remove(self)

    def __enter__(self) -> JumpHandle:
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self.unregister()


class Clock:
    """A clock of a type.

    Parameters
    ----------
    clock_type : ClockType
        With ``ROS_TIME`` a :class:`ROSClock` is made.
    """

    _clock_type: ClockType
    _jump_handles: list[JumpHandle]

    def __new__(cls, *, clock_type: ClockType = ClockType.SYSTEM_TIME) -> Self:
        """Make a clock of the class that the type asks for."""
        if not isinstance(clock_type, ClockType):
            raise TypeError("Clock type must be a ClockType enum")
        if clock_type is ClockType.ROS_TIME and not issubclass(cls, ROSClock):
            cls = ROSClock  # type: ignore[assignment] # noqa: PLW0642 - as rclpy does
        self = super().__new__(cls)
        self._clock_type = clock_type
        self._jump_handles = []
        return self

    @property
    def clock_type(self) -> ClockType:
        """Type of the clock."""
        return self._clock_type

    def __repr__(self) -> str:
        return f"Clock(clock_type={self.clock_type.name})"

    def now(self) -> Time:
        """Time of the clock."""
        return Time(nanoseconds=self._nanoseconds(), clock_type=self._clock_type)

    def _nanoseconds(self) -> int:
        if self._clock_type is ClockType.STEADY_TIME:
            return _time.monotonic_ns()
        return _time.time_ns()

    def _runs_by_itself(self) -> bool:
        """Whether time passes without anybody setting it."""
        return True

    def create_jump_callback(
        self,
        threshold: JumpThreshold,
        *,
        pre_callback: Callable[[], Any] | None = None,
        post_callback: Callable[[TimeJump], Any] | None = None,
    ) -> JumpHandle:
        """Have functions called before and after a jump of simulated time.

        Returns
        -------
        JumpHandle
            Keep it to unregister.
        """
        return JumpHandle(
            clock=self, threshold=threshold, pre_callback=pre_callback, post_callback=post_callback
        )

    def sleep_until(self, until: Time, context: Context | None = None) -> bool:
        """Sleep until this clock reaches a time.

        Returns
        -------
        bool
            False if the context was shut down or the source of time changed.

        Raises
        ------
        NotInitializedException
            If the context is not initialized or shut down.
        ValueError
            If `until` is of another clock type.
        """
        context = get_default_context() if context is None else context
        if not context.ok():
            raise NotInitializedException
        if until.clock_type != self._clock_type:
            raise ValueError("until's clock type does not match this clock's type")
        woken = threading.Event()
        source_changed = False

        def on_jump(jump: TimeJump) -> None:
            nonlocal source_changed
            source_changed |= jump.clock_change != ClockChange.ROS_TIME_NO_CHANGE
            if source_changed or self.now() >= until:
                woken.set()

        context.on_shutdown(woken.set)
        waiter = _Sleep(woken)
        if context.handle is not None:
            context.handle.register(waiter)
        threshold = JumpThreshold(min_forward=Duration(nanoseconds=1), min_backward=None)
        with self.create_jump_callback(threshold, post_callback=on_jump):
            while not woken.is_set() and context.ok():
                left = until.nanoseconds - self._nanoseconds()
                if left <= 0:
                    break
                woken.wait(left / 1e9 if self._runs_by_itself() else None)
        return context.ok() and not source_changed and self.now() >= until

    def sleep_for(self, rel_time: Duration, context: Context | None = None) -> bool:
        """Sleep for a time of this clock. Returns and raises as :meth:`sleep_until`."""
        return self.sleep_until(self.now() + rel_time, context)


class _Sleep:
    """Lets the shutdown by a signal end a sleep."""

    def __init__(self, woken: threading.Event) -> None:
        self._woken = woken

    def interrupt(self) -> None:
        """Wake the sleeper, who looks at the context."""
        self._woken.set()


class ROSClock(Clock):
    """A clock that shows simulated time while a time source provides it, else system time."""

    _is_active: bool = False
    #: Simulated time in nanoseconds.
    _override: int = 0

    def __new__(cls) -> Self:
        """Make a clock; unlike that of :class:`Clock` its type is given."""
        return super().__new__(cls, clock_type=ClockType.ROS_TIME)

    def _nanoseconds(self) -> int:
        return self._override if self._is_active else _time.time_ns()

    def _runs_by_itself(self) -> bool:
        return not self._is_active

    @property
    def ros_time_is_active(self) -> bool:
        """Whether the clock shows simulated time."""
        return self._is_active

    def _set_ros_time_is_active(self, enabled: bool) -> None:
        if enabled == self._is_active:
            return
        change = ClockChange.ROS_TIME_ACTIVATED if enabled else ClockChange.ROS_TIME_DEACTIVATED
        before = self._nanoseconds()
        handles = self._prepare_jump(change, 0)
        self._is_active = enabled
        self._finish_jump(handles, change, self._nanoseconds() - before)

    def set_ros_time_override(self, time: Time) -> None:
        """Set the simulated time."""
        if not isinstance(time, Time):
            raise TypeError(
                f"Time must be specified as rclpy.time.Time. Received type: {type(time)}"
            )
        if not self._is_active:
            self._override = time.nanoseconds
            return
        delta = time.nanoseconds - self._override
        handles = self._prepare_jump(ClockChange.ROS_TIME_NO_CHANGE, delta)
        self._override = time.nanoseconds
        self._finish_jump(handles, ClockChange.ROS_TIME_NO_CHANGE, delta)

    def _prepare_jump(self, change: ClockChange, delta: int) -> list[JumpHandle]:
        handles = [
            handle for handle in self._jump_handles if handle._threshold._is_met(change, delta)
        ]
        for handle in handles:
            if handle._pre_callback is not None:
                handle._pre_callback()
        return handles

    @staticmethod
    def _finish_jump(handles: list[JumpHandle], change: ClockChange, delta: int) -> None:
        jump = TimeJump(change, Duration(nanoseconds=delta))
        for handle in handles:
            if handle._post_callback is not None:
                handle._post_callback(jump)
