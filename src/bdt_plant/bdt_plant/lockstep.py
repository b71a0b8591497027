"""When a plant in lockstep may advance: bookkeeping of the nodes that keep step with it.

The controller answers every measurement, so the command itself is its word. Other nodes (the
twin, a recorder) work at their own pace, beside the loop; each one tells with ``progress``
messages how far it has come and until when it promises not to act on the loop, whatever telemetry
it is still to receive. The plant waits for a follower when it reaches that time, and when the
follower lacks so much telemetry that messages might be lost. Everything that happens in simulated
time is then independent of how fast the computers are.

A follower that is started anew has lost what was published while it was away, and says that it has
seen nothing. It is believed once the one before is silent; then the next batch is awaited, as the
first one of a run is.
"""

from collections.abc import Iterable

from bdt_msgs_py.rejection import MessageRejectedError, Reason

LEAD = 1_000_000_000
"""Simulated time [ns] by which the plant runs ahead of a follower at most."""

LEAD_BATCHES = 20
"""Telemetry batches by which the plant runs ahead of a follower at most."""


RESTART_SILENCE = 0.5
"""Wall time [s] without a word of a follower after which one that begins is no stray."""


class Followers:
    """The nodes that keep step and what they said last.

    Parameters
    ----------
    names : iterable of str
        Names of the nodes; empty names are left out.
    """

    def __init__(self, names: Iterable[str]) -> None:
        self._telemetry_end: dict[str, int] = {name: -1 for name in names if name}
        self._earliest_action: dict[str, int] = dict.fromkeys(self._telemetry_end, 0)
        self._came_on_at: dict[str, float] = {}
        self._heard_at: dict[str, float] = {}
        self._newcomers: dict[str, int] = {}
        self._newest_telemetry = 0
        self._lead = 0

    def __len__(self) -> int:
        return len(self._telemetry_end)

    def telemetry_published(self, end: int) -> None:
        """Note that telemetry was published whose newest sample has the stamp `end` [ns]."""
        # Nobody can promise anything about telemetry that he never saw: the first batch is awaited.
        first = self._newest_telemetry == 0
        self._lead = 0 if first else min(LEAD, LEAD_BATCHES * (end - self._newest_telemetry))
        self._newest_telemetry = end

    def progress(
        self, name: str, telemetry_end: int, earliest_action: int, now: float = 0.0
    ) -> bool:
        """Take the word of a node.

        Parameters
        ----------
        name : str
            Name of the node.
        telemetry_end : int
            Stamp of the newest telemetry sample that it has worked on [ns].
        earliest_action : int
            Time before which it will not act on the loop, whatever it receives [ns].
        now : float
            Wall time [s], of any origin.

        Returns
        -------
        bool
            False if no such node is awaited.

        Raises
        ------
        MessageRejectedError
            For telemetry that was not published yet, or less than the node has told before.
        """
        if name not in self._telemetry_end:
            return False
        # A node that saw a run before this one cannot know of this one before its telemetry.
        end = telemetry_end if self._newest_telemetry else 0
        before = self._telemetry_end[name]
        is_silent = now - self._heard_at.get(name, now) >= RESTART_SILENCE
        if telemetry_end == 0 and before > 0 and is_silent:
            end = self._newest_telemetry
            self._newcomers[name] = end
        if not before <= end <= self._newest_telemetry:
            raise MessageRejectedError(
                Reason.TIME,
                f"{name} has worked on telemetry until {end / 1e9:.9g} s: must be "
                f"{max(before, 0) / 1e9:.9g} to {self._newest_telemetry / 1e9:.9g} s",
            )
        if end > before or earliest_action > self._earliest_action[name]:
            self._came_on_at[name] = now
        self._telemetry_end[name] = end
        self._earliest_action[name] = earliest_action
        self._heard_at[name] = now
        if end > self._newcomers.get(name, end):
            del self._newcomers[name]
        return True

    def stuck(self, names: Iterable[str], since: float) -> list[str]:
        """Return which of the nodes have not come on since a wall time [s], whatever they say."""
        return [name for name in names if self._came_on_at.get(name, since) <= since]

    def blocking(self, time: int) -> list[str]:
        """Return the names of the nodes that do not yet let the plant pass `time` [ns]."""
        return [
            name
            for name, telemetry_end in self._telemetry_end.items()
            if self._earliest_action[name] <= time
            or telemetry_end < self._newest_telemetry - self._lead_of(name)
        ]

    def _lead_of(self, name: str) -> int:
        return 0 if name in self._newcomers else self._lead

    def lagging(self) -> list[str]:
        """Return the names of the nodes that have not yet worked on the newest telemetry."""
        return [
            name
            for name, telemetry_end in self._telemetry_end.items()
            if telemetry_end < self._newest_telemetry
        ]
