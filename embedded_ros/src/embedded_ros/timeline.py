"""What clocks read: nanoseconds since an epoch, from the computer or from a simulation."""

import time
from collections.abc import Callable
from typing import Protocol

from embedded_ros.time_jumps import ClockChange

__all__ = ["JumpListener", "SimulatedTimeline", "Timeline"]


class JumpListener(Protocol):
    """Whoever must know of jumps of simulated time."""

    def concerns(self, change: ClockChange, delta: int) -> bool:
        """Tell whether to be told of a jump by `delta` nanoseconds."""
        ...

    def before_jump(self) -> None:
        """Be told while the old time is still shown."""
        ...

    def after_jump(self, change: ClockChange, delta: int) -> None:
        """Be told when the new time is shown."""
        ...


class Timeline:
    """A reading that passes by itself.

    Parameters
    ----------
    read : callable
        Gives the nanoseconds since the epoch: :func:`time.time_ns`, :func:`time.monotonic_ns`.
    """

    def __init__(self, read: Callable[[], int]) -> None:
        #: Nanoseconds since the epoch.
        self.read = read
        self.listeners: list[JumpListener] = []

    @property
    def passes(self) -> bool:
        """Whether time passes without anybody setting it."""
        return True


class SimulatedTimeline(Timeline):
    """Shows what it was set to last while it is simulated, and system time else."""

    def __init__(self) -> None:
        super().__init__(time.time_ns)
        self.is_simulated = False
        self._set_to = 0

    @property
    def passes(self) -> bool:
        """Whether time passes without anybody setting it."""
        return not self.is_simulated

    def _simulated(self) -> int:
        return self._set_to

    def set(self, nanoseconds: int) -> None:
        """Set the simulated time, at once or for when it is shown."""
        if self.is_simulated:
            self._jump(ClockChange.ROS_TIME_NO_CHANGE, simulated=True, to=nanoseconds)
        else:
            self._set_to = nanoseconds

    def simulate(self, on: bool) -> None:
        """Show the simulated time, or system time."""
        if on and not self.is_simulated:
            self._jump(ClockChange.ROS_TIME_ACTIVATED, simulated=True, to=self._set_to)
        elif self.is_simulated and not on:
            self._jump(ClockChange.ROS_TIME_DEACTIVATED, simulated=False, to=self._set_to)

    def _jump(self, change: ClockChange, *, simulated: bool, to: int) -> None:
        # A change of the source is a jump by nothing, as rcl has it, however far the times are.
        delta = to - self._set_to
        concerned = [each for each in self.listeners if each.concerns(change, delta)]
        for listener in concerned:
            listener.before_jump()
        self._set_to, self.is_simulated = to, simulated
        self.read = self._simulated if simulated else time.time_ns
        for listener in concerned:
            listener.after_jump(change, delta)
