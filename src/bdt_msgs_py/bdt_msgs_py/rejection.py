"""Messages that are not obeyed: one error, one list of reasons, one way to count and to tell."""

from collections import Counter
from enum import StrEnum
from typing import Any

from bdt_msgs_py.command_errors import printable
from bdt_msgs_py.topics import Topic

LONGEST_TEXT = 300
"""Characters of a rejection that are told: what a stranger sends may be of any length."""


class Reason(StrEnum):
    """Why a message is rejected; the words are those of the diagnostics."""

    LAYOUT = "layout"
    """Wrong joint names, lengths, labels or sizes."""
    STAMP = "stamp"
    """A stamp that is no time."""
    NOT_FINITE = "not_finite"
    """NaN or infinite."""
    RANGE = "range"
    """A number that no machine has."""
    TIME = "time"
    """A time that nobody awaits: too old, too new, or not that of a question."""
    CHANGE = "change"
    """A reading that the machine cannot have reached since the one before."""
    SAMPLES = "samples"
    """Samples with a hole or at another rate."""
    REPEATED = "repeated"
    """Another answer to what was answered."""
    SOURCE = "source"
    """From another source than the one that is obeyed."""


class MessageRejectedError(ValueError):
    """A message from outside is not obeyed; the text is one line that says why.

    Parameters
    ----------
    reason : Reason
        What is counted.
    text : str
        Field, value and what is allowed.
    """

    def __init__(self, reason: Reason, text: str) -> None:
        super().__init__(printable(text)[:LONGEST_TEXT])
        self.reason = reason


class RejectedMessages:
    """Counts rejected messages by topic and reason, for the log and the diagnostics of a node.

    Parameters
    ----------
    logger : logger of a node
        Gets one warning a second at most.
    """

    def __init__(self, logger: Any) -> None:
        self._logger = logger
        self._counts: Counter[tuple[str, str]] = Counter()
        self._last = ""

    @property
    def total(self) -> int:
        """Number of rejected messages."""
        return self._counts.total()

    def count(self, topic: Topic, error: MessageRejectedError) -> None:
        """Count a message of `topic` and tell why it was rejected."""
        self._counts[_name(topic), str(error.reason)] += 1
        self._last = f"{topic.name}: {error}"
        self._logger.warning(f"rejected {self._last}", throttle_duration_sec=1.0)

    def by_reason(self, topic: Topic) -> Counter[str]:
        """Return how many messages of a topic were rejected for each reason."""
        counts = self._counts.items()
        return Counter({reason: count for (name, reason), count in counts if name == _name(topic)})

    def values(self) -> dict[str, object]:
        """Return what the diagnostics say: the same keys for every node."""
        counts = sorted(self._counts.items())
        by_reason = ", ".join(f"{name} {reason}: {count}" for (name, reason), count in counts)
        return {
            "rejected_messages": self.total,
            "rejected_messages_by_reason": by_reason,
            "last_rejected_message": self._last,
        }


def _name(topic: Topic) -> str:
    return topic.name.lstrip("/")
