"""Simulated time: one source, and the timelines that show it."""

from embedded_ros.timeline import SimulatedTimeline

__all__ = ["SimulatedTime"]


class SimulatedTime:
    """Tells timelines what time it is in a simulation, and whether they show it."""

    def __init__(self) -> None:
        self.is_shown = False
        # Zero stands for "nobody has told yet".
        self._latest = 0
        self._timelines: list[SimulatedTimeline] = []

    def drive(self, timeline: SimulatedTimeline) -> None:
        """Tell a timeline, from now on; it keeps up with the others at once."""
        timeline.set(self._latest)
        timeline.simulate(self.is_shown)
        if timeline not in self._timelines:
            self._timelines.append(timeline)

    def tell(self, nanoseconds: int) -> None:
        """Have it be a time, earlier ones included."""
        self._latest = nanoseconds
        for timeline in self._timelines:
            timeline.set(nanoseconds)

    def show(self, on: bool) -> None:
        """Have the timelines show simulated time, or system time."""
        self.is_shown = on
        for timeline in self._timelines:
            timeline.simulate(on)
