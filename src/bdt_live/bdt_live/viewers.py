"""The pages that are open: each gets what it can take, and none makes another one wait."""

import asyncio
from collections import deque
from collections.abc import Iterable

MOST_WAITING = 50
"""Messages that wait for a page; one with more is behind, and begins anew from the history."""

HISTORY = 60.0
"""Time of the frames that a page gets when it comes, or was behind [s]."""


class Viewer:
    """A page that is open.

    Parameters
    ----------
    number : int
        By which replies find it.
    """

    def __init__(self, number: int) -> None:
        self.number = number
        self._waiting: deque[str] = deque()
        self._news = asyncio.Event()
        self.is_behind = True
        self._news.set()

    def put(self, text: str) -> None:
        """Give the page a message, unless it has to begin anew first."""
        if self.is_behind:
            return
        if len(self._waiting) >= MOST_WAITING:
            self._waiting.clear()
            self.is_behind = True
        else:
            self._waiting.append(text)
        self._news.set()

    async def next(self) -> str | None:
        """Return the next message; None when the page has to begin anew."""
        while True:
            await self._news.wait()
            if self.is_behind:
                self.is_behind = False
                return None
            if self._waiting:
                return self._waiting.popleft()
            self._news.clear()


class History:
    """Frames of the last minute."""

    def __init__(self) -> None:
        self._frames: deque[tuple[float, str]] = deque()

    def add(self, begin: float, text: str) -> None:
        """Add a frame that begins at a time [s]; an earlier one than before begins a new run."""
        if self._frames and begin < self._frames[-1][0]:
            self._frames.clear()
        self._frames.append((begin, text))
        while self._frames[0][0] < begin - HISTORY:
            self._frames.popleft()

    def text(self) -> str:
        """Return one message with all frames."""
        frames = ",".join(text for _, text in self._frames)
        return f'{{"type":"history","frames":[{frames}]}}'


class Viewers:
    """All pages that are open."""

    def __init__(self) -> None:
        self._viewers: dict[int, Viewer] = {}
        self._count = 0
        self.history = History()

    def __len__(self) -> int:
        return len(self._viewers)

    def add(self) -> Viewer:
        """Add a page."""
        self._count += 1
        viewer = self._viewers[self._count] = Viewer(self._count)
        return viewer

    def remove(self, viewer: Viewer) -> None:
        """Forget a page."""
        del self._viewers[viewer.number]

    def tell(self, text: str, only: int | None = None) -> None:
        """Give all pages a message, or one of them."""
        chosen: Iterable[Viewer] = self._viewers.values()
        if only is not None:
            chosen = [self._viewers[only]] if only in self._viewers else []
        for viewer in chosen:
            viewer.put(text)
