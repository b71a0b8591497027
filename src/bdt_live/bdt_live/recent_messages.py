"""The last minute of a loop, as messages, and as a bag when somebody wants it."""

from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from bdt_bags.writing.bag_files import BagFiles
from bdt_bags.writing.topic_metadata import SerializedMessage, TopicMetadata

DURATION = 60_000_000_000
"""Wall time for which messages are kept [ns]."""

MOST_BYTES = 128 << 20
"""Memory that they may take: simulated time may go fast."""


class Held(Protocol):
    """What of the messages of a topic holds on when they are forgotten."""

    def take(self, message: SerializedMessage) -> None:
        """Take a message that is forgotten."""

    def messages(self) -> list[SerializedMessage]:
        """Return what says the same in messages."""


class LastMessage:
    """A topic whose last message holds until the next one comes, as late subscribers get it."""

    def __init__(self) -> None:
        self._last: list[SerializedMessage] = []

    def take(self, message: SerializedMessage) -> None:
        """Take a message that is forgotten."""
        self._last = [message]

    def messages(self) -> list[SerializedMessage]:
        """Return the last one that was forgotten, if any."""
        return self._last


class RecentMessages:
    """Keeps the messages of the last minute, and of older ones what still holds.

    Attributes
    ----------
    topics : list of TopicMetadata
        Topics by the number of their messages.
    """

    def __init__(self) -> None:
        self.topics: list[TopicMetadata] = []
        self._held: dict[int, Held] = {}
        self._messages: deque[SerializedMessage] = deque()
        self._size = 0

    def add_topic(self, topic: TopicMetadata, held: Held | None = None) -> int:
        """Add a topic and return its number.

        Parameters
        ----------
        topic : TopicMetadata
            What a bag says of it.
        held : Held, optional
            What holds on of its messages; nothing without.
        """
        self.topics.append(topic)
        number = len(self.topics) - 1
        if held is not None:
            self._held[number] = held
        return number

    def add(self, message: SerializedMessage) -> None:
        """Add a message, and forget those that are too old or too many."""
        self._messages.append(message)
        self._size += len(message.data)
        oldest = message.received - DURATION
        while self._messages[0].received < oldest or self._size > MOST_BYTES:
            left = self._messages.popleft()
            self._size -= len(left.data)
            if left.topic in self._held:
                self._held[left.topic].take(left)

    def messages(self) -> list[SerializedMessage]:
        """Return what a bag of the last minute holds: what has held before it comes first."""
        recent = list(self._messages)
        if not recent:
            return []
        begin = recent[0].received
        held = [message for each in self._held.values() for message in each.messages()]
        return [*(message._replace(received=begin) for message in held), *recent]


def write_bag(
    folder: Path, topics: Sequence[TopicMetadata], messages: Sequence[SerializedMessage]
) -> None:
    """Write messages as a bag.

    Parameters
    ----------
    folder : Path
        New folder.
    topics : sequence of TopicMetadata
        Topics by number.
    messages : sequence of SerializedMessage
        In the order of their reception.

    Raises
    ------
    OSError, bdt_bags.writing.topic_metadata.BagWriteError
        If the disk refuses.
    """
    files = BagFiles(folder)
    for topic in topics:
        files.add_topic(topic)
    files.append(messages)
    files.close()
