"""Clocks, simulated time and jumps of it."""

import threading
import time as _time
from collections.abc import Callable
from contextlib import AbstractContextManager
from types import TracebackType
from typing import Any, Self

from embedded_ros.errors import NotInitializedException
from embedded_ros.public_names import shown_in
from embedded_ros.time_jumps import ClockChange, JumpThreshold, TimeJump
from embedded_ros.timeline import SimulatedTimeline, Timeline
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.duration import Duration
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

shown_in(__name__, ClockChange, JumpThreshold, TimeJump)


class JumpHandle(AbstractContextManager["JumpHandle"]):
    """A registered jump callback; a context manager that unregisters it.

    Made by :meth:`Clock.create_jump_callback`.
    """

    def __init__(
        self,
        *,
        clock: "Clock",
        threshold: JumpThreshold,
        pre_callback: Callable[[], Any] | None,
        post_callback: Callable[[TimeJump], Any] | None,
    ) -> None:
        given = {"pre_callback": pre_callback, "post_callback": post_callback}
        given = {name: value for name, value in given.items() if value is not None}
        if not given:
            raise ValueError("One of pre_callback or post_callback must be callable")
        for name, value in given.items():
            if not callable(value):
                raise ValueError(f"{name} must be callable if given")
        self._before = pre_callback
        self._after = post_callback
        #: Which jumps the callbacks are for.
        self.concerns = threshold.is_met
        self._listeners = clock._timeline.listeners
        self._listeners.append(self)

    def before_jump(self) -> None:
        """Call back while the old time is still shown."""
        if self._before is not None:
            self._before()

    def after_jump(self, change: ClockChange, delta: int) -> None:
        """Call back when the new time is shown."""
        if self._after is not None:
            self._after(TimeJump(change, Duration(nanoseconds=delta)))

    def unregister(self) -> None:
        """Remove the callback. Again is fine."""
        if self in self._listeners:
            self._listeners.remove(self)

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.unregister()


class Clock:
    """A clock of a type.

    Parameters
    ----------
    clock_type : ClockType
        With ``ROS_TIME`` a :class:`ROSClock` is made.
    """

    _type: ClockType
    _timeline: Timeline

    def __new__(cls, *, clock_type: ClockType = ClockType.SYSTEM_TIME) -> Self:
        """Make a clock of the class that the type asks for."""
        if not isinstance(clock_type, ClockType):
            raise TypeError("Clock type must be a ClockType enum")
        is_simulated = clock_type is ClockType.ROS_TIME
        is_class_right = issubclass(cls, ROSClock) or not is_simulated
        clock: Any = super().__new__(cls if is_class_right else ROSClock)
        clock._type = clock_type
        if is_simulated:
            clock._timeline = SimulatedTimeline()
        else:
            is_steady = clock_type is ClockType.STEADY_TIME
            clock._timeline = Timeline(_time.monotonic_ns if is_steady else _time.time_ns)
        return clock  # type: ignore[no-any-return]

    @property
    def clock_type(self) -> ClockType:
        """Type of the clock."""
        return self._type

    def __repr__(self) -> str:
        return f"Clock(clock_type={self._type.name})"

    def now(self) -> Time:
        """Time of the clock."""
        return Time(nanoseconds=self._timeline.read(), clock_type=self._type)

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
        context = context or get_default_context()
        if not context.ok():
            raise NotInitializedException
        if until.clock_type is not self._type:
            raise ValueError("until's clock type does not match this clock's type")
        return _Sleep(self._timeline, until.nanoseconds).run(context)

    def sleep_for(self, rel_time: Duration, context: Context | None = None) -> bool:
        """Sleep for a time of this clock. Returns and raises as :meth:`sleep_until`."""
        return self.sleep_until(self.now() + rel_time, context)


class _Sleep:
    """A sleep on a timeline, which jumps and the shutdown of the context interrupt."""

    def __init__(self, timeline: Timeline, until: int) -> None:
        self._timeline = timeline
        self._until = until
        self._news = threading.Event()
        self._source_changed = False

    def run(self, context: Context) -> bool:
        """Sleep; tell whether the time is reached."""
        context.on_shutdown(self.interrupt)
        if context.handle is not None:
            context.handle.register(self)
        self._timeline.listeners.append(self)
        try:
            while context.ok() and not self._source_changed:
                left = self._until - self._timeline.read()
                if left <= 0:
                    return True
                self._news.wait(left / 1e9 if self._timeline.passes else None)
                self._news.clear()
        finally:
            self._timeline.listeners.remove(self)
        return False

    def interrupt(self) -> None:
        """Wake the sleeper, who looks at the context."""
        self._news.set()

    def concerns(self, change: ClockChange, delta: int) -> bool:
        """Look up at every jump but those backward."""
        return delta > 0 or change is not ClockChange.ROS_TIME_NO_CHANGE

    def before_jump(self) -> None:
        """Sleep on: nothing has changed yet."""

    def after_jump(self, change: ClockChange, delta: int) -> None:  # noqa: ARG002
        """Wake the sleeper, who looks at the time."""
        self._source_changed |= change is not ClockChange.ROS_TIME_NO_CHANGE
        self._news.set()


class ROSClock(Clock):
    """A clock that shows simulated time while a time source provides it, else system time."""

    _timeline: SimulatedTimeline

    def __new__(cls) -> Self:
        """Make a clock; unlike that of :class:`Clock` its type is given."""
        return super().__new__(cls, clock_type=ClockType.ROS_TIME)

    @property
    def ros_time_is_active(self) -> bool:
        """Whether the clock shows simulated time."""
        return self._timeline.is_simulated

    # rclpy keeps this method private, and programs that simulate time call it.
    def _set_ros_time_is_active(self, enabled: bool) -> None:
        self._timeline.simulate(enabled)

    def set_ros_time_override(self, time: Time) -> None:
        """Set the simulated time."""
        if isinstance(time, Time):
            self._timeline.set(time.nanoseconds)
            return
        raise TypeError(f"Time must be specified as rclpy.time.Time. Received type: {type(time)}")
