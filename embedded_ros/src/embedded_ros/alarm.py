"""A periodic due time on a timeline: what is below timers."""

from collections.abc import Callable
from enum import Enum

from embedded_ros.time_jumps import ClockChange
from embedded_ros.timeline import Timeline

__all__ = ["Alarm", "AlarmState"]


class AlarmState(Enum):
    """What an alarm does."""

    RUNNING = 0
    CANCELED = 1
    CLOSED = 2


class Alarm:
    """Becomes due every `period`; what was missed is left out.

    Parameters
    ----------
    timeline : Timeline
        On which the period counts.
    period : int
        Nanoseconds, not negative; a new one counts from the next ring on.
    on_change : callable
        Called when the alarm may be due sooner than it was when somebody looked last.
    running : bool
        If false it waits for :meth:`restart`.
    """

    def __init__(
        self,
        timeline: Timeline,
        period: int,
        on_change: Callable[[], None],
        *,
        running: bool = True,
    ) -> None:
        self.period = period
        self.on_change = on_change
        self.state = AlarmState.RUNNING if running else AlarmState.CANCELED
        self._timeline = timeline
        #: When it rang last, or was made.
        self._rang_at = timeline.read()
        self._due_at = self._rang_at + period
        # What was left when a change of the source began; zero: nothing known.
        self._left_over = 0
        timeline.listeners.append(self)

    def ring(self) -> bool:
        """Tell whether the alarm is due, and reckon the next time if it is."""
        now = self._timeline.read()
        late = now - self._due_at
        if late < 0 or self.state is not AlarmState.RUNNING:
            return False
        self._rang_at = now
        # On to the next multiple that is not over. Without a period it is due at every look.
        self._due_at += max(1, -(-late // self.period)) * self.period if self.period else late
        return True

    def due_in(self) -> int | None:
        """Nanoseconds to wait for; None if waiting does not help."""
        if self.state is not AlarmState.RUNNING:
            return None
        left = self._due_at - self._timeline.read()
        if left <= 0:
            return 0
        return left if self._timeline.passes else None

    def time_left(self) -> int:
        """Nanoseconds until the alarm is due; negative if it is overdue."""
        return self._due_at - self._timeline.read()

    def since_ring(self) -> int:
        """Nanoseconds since it rang last, or since it was made."""
        return self._timeline.read() - self._rang_at

    def cancel(self) -> None:
        """Be due no more until :meth:`restart`."""
        self.state = AlarmState.CANCELED

    def restart(self) -> None:
        """Be due a period from now."""
        self.state = AlarmState.RUNNING
        self._due_at = self._timeline.read() + self.period
        self.on_change()

    def close(self) -> None:
        """Be due no more, and follow the timeline no more. Again is fine."""
        if self.state is not AlarmState.CLOSED:
            self.state = AlarmState.CLOSED
            self._timeline.listeners.remove(self)

    # ------------------------------------------------------------------ jumps of simulated time

    def concerns(self, change: ClockChange, delta: int) -> bool:
        """Follow every jump."""
        return delta != 0 or change is not ClockChange.ROS_TIME_NO_CHANGE

    def before_jump(self) -> None:
        """Note what is left of the period, for a change of the source."""
        now = self._timeline.read()
        self._left_over = self._due_at - now if now else 0

    def after_jump(self, change: ClockChange, delta: int) -> None:
        """Count the period on the new time.

        After a change of the source what was left counts as over, as rcl has it: the alarm is due
        a period later than that. Time that runs backward begins the period anew.
        """
        now = self._timeline.read()
        if change is not ClockChange.ROS_TIME_NO_CHANGE:
            if now and self._left_over:
                self._begin_at(now - self._left_over)
        elif self._due_at > now:
            if delta < 0 and now < self._rang_at:
                self._begin_at(now)
            return
        self.on_change()

    def _begin_at(self, moment: int) -> None:
        self._rang_at = moment
        self._due_at = moment + self.period
