"""When a plant in lockstep may advance: bookkeeping of the nodes that keep step with it.

The controller answers every measurement, so the command itself is its word. Other nodes (the
twin, a recorder) work at their own pace; each one tells how far it has come with ``progress``
messages. The plant waits for a follower in two cases only: it has not yet taken the newest
telemetry, or it announced to act on the loop at the very time that the plant has reached.
Everything that happens in simulated time is then independent of how fast the computers are.
"""

from collections.abc import Iterable


class Followers:
    """The nodes that keep step and what they said last.

    Parameters
    ----------
    names : iterable of str
        Names of the nodes; empty names are left out.
    """

    def __init__(self, names: Iterable[str]) -> None:
        self._telemetry_end: dict[str, int] = {name: -1 for name in names if name}
        self._acts_at: dict[str, int] = dict.fromkeys(self._telemetry_end, 0)
        self._newest_telemetry = 0

    def __len__(self) -> int:
        return len(self._telemetry_end)

    def telemetry_published(self, end: int) -> None:
        """Note that telemetry was published whose newest sample has the stamp `end` [ns]."""
        self._newest_telemetry = end

    def progress(self, name: str, telemetry_end: int, acts_at: int) -> bool:
        """Take the word of a node.

        Parameters
        ----------
        name : str
            Name of the node.
        telemetry_end : int
            Stamp of the newest telemetry sample that it took [ns].
        acts_at : int
            Time before which it will not act on the loop [ns].

        Returns
        -------
        bool
            False if no such node is awaited.
        """
        if name not in self._telemetry_end:
            return False
        self._telemetry_end[name] = telemetry_end
        self._acts_at[name] = acts_at
        return True

    def holding(self, time: int) -> list[str]:
        """Return the names of the nodes that do not yet let the plant pass `time` [ns]."""
        return [
            name
            for name, telemetry_end in self._telemetry_end.items()
            if telemetry_end < self._newest_telemetry or self._acts_at[name] <= time
        ]
