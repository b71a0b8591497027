"""Which command a plant obeys: the first answer to a measurement that it published, of one source.

A command that answers nothing says nothing about the state that the plant is in, however new its
stamp is; and two controllers that take turns are none.
"""

from collections import OrderedDict

from bdt_msgs_py.message_checks import VoltageCommand
from bdt_msgs_py.rejection import MessageRejectedError, Reason

LARGEST_MEMORY = 10_000
"""Measurements that are remembered at most."""
ANSWERS_KEPT = 100
"""Newest answers, by which one that comes late is told from one that answers nothing."""


class AwaitedCommands:
    """Measurements that await an answer, and the source whose answers are obeyed.

    The first source that answers is obeyed until it has been silent for a while.

    Parameters
    ----------
    source_timeout : float
        Wall time [s] after which another source may take over a measurement without an answer.
    """

    def __init__(self, source_timeout: float) -> None:
        self._source_timeout = source_timeout
        self._awaited: OrderedDict[int, None] = OrderedDict()
        self._source: str | None = None
        self._asked_at: float | None = None
        self._answers: OrderedDict[int, VoltageCommand] = OrderedDict()

    def published(self, stamp: int, oldest: int, now: float) -> None:
        """Note that a measurement was published.

        Parameters
        ----------
        stamp : int
            Its stamp [ns].
        oldest : int
            Stamp of the oldest measurement that may still be answered [ns].
        now : float
            Wall time [s], of any origin.
        """
        if self._asked_at is None:
            self._asked_at = now
        self._awaited[stamp] = None
        while len(self._awaited) > LARGEST_MEMORY or next(iter(self._awaited)) < oldest:
            self._awaited.popitem(last=False)

    def accept(self, command: VoltageCommand, now: float) -> bool:
        """Take a command.

        Parameters
        ----------
        command : VoltageCommand
            The command.
        now : float
            Wall time [s], of any origin.

        Returns
        -------
        bool
            True if it is to be obeyed; False for the very answer that was taken before, which
            comes when a measurement was sent twice.

        Raises
        ------
        MessageRejectedError
            If it answers no measurement that awaits an answer, or comes from another source.
        """
        answer = self._answers.get(command.stamp)
        if answer is None and command.stamp not in self._awaited:
            raise self._rejection(Reason.TIME, command, "awaits no answer")
        is_silent = self._asked_at is not None and now - self._asked_at >= self._source_timeout
        if self._source not in (None, command.source) and not is_silent:
            raise MessageRejectedError(
                Reason.SOURCE,
                f"from {command.source!r}: commands are taken from {self._source!r} alone",
            )
        if command == answer:
            return False
        if answer is not None:
            raise self._rejection(Reason.REPEATED, command, "is answered already")
        while self._awaited.popitem(last=False)[0] != command.stamp:
            pass  # whatever is older has been overtaken
        self._source, self._asked_at = command.source, None
        self._answers[command.stamp] = command
        if len(self._answers) > ANSWERS_KEPT:
            self._answers.popitem(last=False)
        return True

    @staticmethod
    def _rejection(reason: Reason, command: VoltageCommand, text: str) -> MessageRejectedError:
        return MessageRejectedError(
            reason, f"stamp {command.stamp / 1e9:.9g} s: a measurement of this time {text}"
        )
