"""When the next file of a bag begins."""

from collections.abc import Sequence
from dataclasses import dataclass

from bdt_bags.writing.metadata_file import FileInformation
from bdt_bags.writing.topic_metadata import SerializedMessage

SMALLEST_PIECE = 1 << 16
"""Messages between two looks at the size of a file that is to be split [byte]."""
MESSAGE_OVERHEAD = 50
"""What a message takes in a file besides its content, roughly [byte]."""


@dataclass(frozen=True)
class FileSplitting:
    """Limits of a file.

    Attributes
    ----------
    size : int
        Size from which on a new file is begun [byte]; 0 for no limit.
    duration : int
        Time of reception between first and last message of a file [ns]; 0 for no limit.
    """

    size: int = 0
    duration: int = 0

    def is_full(self, file: FileInformation, written: int, message: SerializedMessage) -> bool:
        """Tell whether a message belongs into the next file.

        Parameters
        ----------
        file : FileInformation
            What is in this one; a file without a message is never full.
        written : int
            Its size [byte].
        message : SerializedMessage
            The next message.
        """
        if not file.message_count:
            return False
        if self.size and written >= self.size:
            return True
        return bool(self.duration) and message.received >= file.start + self.duration

    def next_piece(
        self, file: FileInformation, written: int, waiting: Sequence[SerializedMessage]
    ) -> list[SerializedMessage]:
        """Return what goes into this file before the next look at it.

        Parameters
        ----------
        file : FileInformation
            What is in the file, which is not full.
        written : int
            Its size [byte].
        waiting : sequence of SerializedMessage
            At least one message.

        Returns
        -------
        list of SerializedMessage
            The first of them, one at least.
        """
        if not self.size and not self.duration:
            return list(waiting)
        start = file.start if file.message_count else waiting[0].received
        end = start + self.duration if self.duration else float("inf")
        room = max(self.size - written, SMALLEST_PIECE) if self.size else float("inf")
        for number, message in enumerate(waiting):
            room -= len(message.data) + MESSAGE_OVERHEAD
            if number and message.received >= end:
                return list(waiting[:number])
            if room < 0:
                return list(waiting[: number + 1])
        return list(waiting)
