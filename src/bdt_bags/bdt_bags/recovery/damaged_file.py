"""What is told of one damaged file while its messages are read."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Protocol

from bdt_bags.writing.topic_metadata import SerializedMessage, TopicMetadata


@dataclass
class Damage:
    """What could not be understood.

    Attributes
    ----------
    byte_count : int
        Bytes of the file that were passed over.
    remarks : list of str
        One line for each damaged place, the first :data:`LONGEST_LIST` of them.
    """

    byte_count: int = 0
    remarks: list[str] = field(default_factory=list)

    def note(self, remark: str, byte_count: int = 0) -> None:
        """Add one damaged place."""
        self.byte_count += byte_count
        if len(self.remarks) < LONGEST_LIST:
            self.remarks.append(remark)


LONGEST_LIST = 20


class DamagedFile(Protocol):
    """A damaged file: topics that it declares, and its messages in the order of the file."""

    topics: list[TopicMetadata]
    damage: Damage
    compression: str

    def messages(self) -> Iterator[SerializedMessage]:
        """Iterate over the messages; their topic is the place in `topics`."""
        ...
