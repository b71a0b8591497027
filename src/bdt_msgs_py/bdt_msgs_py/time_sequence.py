"""Times that go on from one message to the next, and strays that do not belong to them."""

from enum import Enum

from bdt_msgs_py.reading import NANOSECONDS_PER_SECOND
from bdt_msgs_py.rejection import MessageRejectedError, Reason

SILENCE = 0.1
"""Wall time [s] without a message in sequence before others may take its place."""


class Step(Enum):
    """How an accepted time follows the one before."""

    BEGINS = "begins"
    """The first one, or time has gone back for good: another run begins."""
    CONTINUES = "continues"
    REPEATS = "repeats"
    """The very time that was accepted last."""


class TimeSequence:
    """Tells messages that continue a sequence from strays, by their times.

    A time is accepted up to `tolerance` after the newest accepted one. What lies elsewhere is
    rejected until as many as `confirmations` of them in a row continue each other, with none in
    sequence among them and none for a while before: then the source has really gone elsewhere.
    A clock that was seen to go back speaks for the first of them.

    Parameters
    ----------
    tolerance : int
        Largest step forward [ns].
    confirmations : int
        Messages in a row that make a new sequence.
    """

    def __init__(self, tolerance: int, confirmations: int) -> None:
        self._tolerance, self._confirmations = tolerance, confirmations
        self.newest: int | None = None
        self._before: int | None = None
        self._accepted_at = 0.0
        self._candidate = self._candidates = 0
        self._clock_went_back = False

    def expect_restart(self) -> None:
        """Note that simulated time has gone back: so will the times of messages."""
        self._clock_went_back = self.newest is not None

    def continues(self, time: int) -> bool:
        """Tell whether a time is a step forward that needs no confirmation."""
        return self.newest is not None and 0 < time - self.newest <= self._tolerance

    def check(self, time: int, now: float) -> Step:
        """Take the time of the next message.

        Parameters
        ----------
        time : int
            Time of the message [ns].
        now : float
            Wall time [s], of any origin.

        Raises
        ------
        MessageRejectedError
            If the message does not belong to the sequence.
        """
        if self.newest is None:
            return self._accept(time, now, Step.BEGINS)
        ahead = time - self.newest
        if ahead == 0:
            return self._accept(time, now, Step.REPEATS)
        if self.continues(time):
            self._before = self.newest
            return self._accept(time, now, Step.CONTINUES)
        if self._before is not None and self._before < time < self.newest:
            # The sequence goes on below the newest time, which was a stray from near by.
            return self._accept(time, now, Step.CONTINUES)
        step = Step.BEGINS if ahead < -self._tolerance else Step.CONTINUES
        if (ahead < 0 and self._clock_went_back) or self._is_confirmed(time, now):
            self._before = None
            return self._accept(time, now, step)
        side = "after" if ahead > 0 else "before"
        raise MessageRejectedError(
            Reason.TIME,
            f"time {_seconds(time)}: is {_seconds(abs(ahead))} {side} the newest accepted, "
            f"must be 0 to {_seconds(self._tolerance)} after it",
        )

    def _is_confirmed(self, time: int, now: float) -> bool:
        follows = self._candidates and 0 <= time - self._candidate <= self._tolerance
        self._candidates = self._candidates + 1 if follows else 1
        self._candidate = time
        return self._candidates >= self._confirmations and now - self._accepted_at >= SILENCE

    def _accept(self, time: int, now: float, step: Step) -> Step:
        self.newest, self._accepted_at = time, now
        self._candidates, self._clock_went_back = 0, False
        return step


def _seconds(time: int) -> str:
    return f"{time / NANOSECONDS_PER_SECOND:.9g} s"
