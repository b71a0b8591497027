"""Bags: take the raw messages of the project's topics out of any rosbag2 recording.

Reading is by ``rosbags`` alone, so a bag can be looked at where there is no ROS. The bag is only
ever opened for reading.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import compress, islice
from pathlib import Path
from struct import error as StructError  # noqa: N812 - the module's name for it says nothing
from typing import Any, cast

import apsw
import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import ConnectionExtRosbag2
from rosbags.rosbag2 import Reader, ReaderError
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore
from ruamel.yaml.error import YAMLError

from bdt_bags.bag_error import BagError, one_line
from bdt_bags.reading.bounded_decompression import (
    ALWAYS_ALLOWED,
    ZSTD_MAGIC,
    allowed_size,
    decompress_message,
)
from bdt_bags.reading.storage_files import recovery_hint, storage_files
from bdt_bags.reading.topic_selection import RecordedTopic, TopicSelection, select_topics
from bdt_msgs_py.topics import JOINT_STATE, MEASUREMENT, TELEMETRY, Topic

__all__ = ["BagError", "RawBag", "RawTopic", "decode", "read_bag"]

FloatArray = NDArray[np.float64]

DAMAGED_BAG = (
    ReaderError,  # what rosbags checks
    SerdeError,
    OSError,
    apsw.Error,  # damaged pages of sqlite, met while reading messages
    YAMLError,  # quality of service profiles
    RecursionError,  # the same, nested
    # rosbags unpacks lengths and fields as they stand; what lies behind the end of a record, a
    # value of no enumeration or a text that is not UTF-8 makes any of these:
    StructError,
    AssertionError,
    AttributeError,
    EOFError,
    LookupError,
    OverflowError,
    TypeError,
    ValueError,
)
"""What reading a damaged bag raises."""


@dataclass(frozen=True)
class RawTopic:
    """The messages of one topic as they stand in the bag.

    Attributes
    ----------
    name : str
        Topic name in the bag, with its namespace.
    message_type : str
        ROS type name.
    received : list of int
        Receive times [ns], in the order of the bag.
    data : list of bytes
        Serialized messages (CDR), one for each receive time.
    batches : list of ndarray, shape (n, c)
        Rows of samples in each message, once they have been read; empty for other topics.
    """

    name: str
    message_type: str
    received: list[int] = field(default_factory=list)
    data: list[bytes] = field(default_factory=list)
    batches: list[FloatArray] = field(default_factory=list)

    @property
    def namespace(self) -> str:
        """Return what stands before the last name component, without the last slash."""
        return self.name.rpartition("/")[0]

    def one(self, number: int) -> "RawTopic":
        """Return one message of the topic, as a topic of its own."""
        return replace(self, received=[self.received[number]], data=[self.data[number]], batches=[])

    def only(self, kept: Sequence[bool] | NDArray[np.bool_]) -> "RawTopic":
        """Return the messages that are chosen, one by one."""
        return replace(
            self,
            received=list(compress(self.received, kept)),
            data=list(compress(self.data, kept)),
            batches=list(compress(self.batches, kept)),
        )


@dataclass(frozen=True)
class RawBag:
    """What the analysis takes from a bag.

    Attributes
    ----------
    path : Path
        The bag.
    topics : mapping of Topic to RawTopic
        The topics of the public interface that hold messages; telemetry or measurement always is
        one of them.
    message_counts : mapping of str to int
        Number of messages of every topic in the bag, by its name there.
    run_limits : sequence of int
        Receive times [ns] from which on messages belong to the next run; one less than runs.
    left_out : mapping of str to sequence of int
        Receive times [ns] of messages that fit into no run, by topic name.
    """

    path: Path
    topics: Mapping[Topic, RawTopic]
    message_counts: Mapping[str, int]
    run_limits: Sequence[int] = ()
    left_out: Mapping[str, Sequence[int]] = field(default_factory=dict)


def read_bag(path: Path, selection: TopicSelection | None = None) -> RawBag:
    """Read the raw messages of the project's topics.

    Parameters
    ----------
    path : Path
        A rosbag2 folder (mcap or sqlite3, compressed or not) or a file of one.
    selection : TopicSelection, optional
        Which topics are meant where the bag does not tell.

    Raises
    ------
    BagError
        If this is not a readable bag, or if it holds neither telemetry nor measurements.
    """
    path = Path(path)
    with _one_line_for_damage(path), storage_files(path) as files, ExitStack() as stack:
        readers = [stack.enter_context(Reader(file)) for file in files]
        connections = [connection for reader in readers for connection in reader.connections]
        recorded = {RecordedTopic(x.topic, x.msgtype) for x in connections}
        try:
            chosen = select_topics(
                recorded,
                selection or TopicSelection(),
                lambda topic: _content(path, readers, topic),
            )
        except BagError as error:
            raise BagError(f"bag {path}: {error}") from None
        counts = dict.fromkeys(sorted(x.topic for x in connections), 0)
        for connection in connections:
            counts[connection.topic] += connection.msgcount
        topics = {topic: RawTopic(*name) for topic, name in chosen.items()}
        limit = allowed_size(sum(file.stat().st_size for file in files))
        for reader in readers:
            limit = _fill(path, reader, topics, limit)
    counts.update({raw.name: len(raw.data) for raw in topics.values()})
    topics = {topic: raw for topic, raw in topics.items() if raw.data}
    if not topics.keys() & {TELEMETRY, MEASUREMENT}:
        names = sorted(x.name for topic, x in chosen.items() if topic in {TELEMETRY, MEASUREMENT})
        have = "has" if len(names) == 1 else "have"
        raise BagError(
            f"bag {path}: {' and '.join(names)} {have} no messages: must have at least one"
        )
    return RawBag(path, topics, counts)


def decode(path: Path, raw: RawTopic) -> list[Any]:
    """Return the messages of a topic as objects.

    Raises
    ------
    BagError
        If one is damaged.
    """
    messages = []
    for number, data in enumerate(raw.data):
        try:
            messages.append(typestore().deserialize_cdr(data, raw.message_type))
        except (*DAMAGED_BAG, MemoryError) as error:
            raise BagError(
                f"bag {path}: message {number} of {raw.name} is damaged: {one_line(error)}"
            ) from error
    return messages


@cache
def typestore() -> Typestore:
    """Return the message definitions of ROS 2 Jazzy."""
    return get_typestore(Stores.ROS2_JAZZY)


@contextmanager
def _one_line_for_damage(path: Path) -> Iterator[None]:
    try:
        yield
    except BagError:
        raise
    except MemoryError:
        raise BagError(f"bag {path}: holds more data than fits in memory") from None
    except OSError as error:
        raise BagError(f"bag {path}: cannot be read: {error.strerror or one_line(error)}") from None
    except DAMAGED_BAG as error:
        raise BagError(
            f"bag {path}: is not a readable rosbag2 bag: {one_line(error)}{recovery_hint(path)}"
        ) from error


def _fill(path: Path, reader: Reader, topics: Mapping[Topic, RawTopic], limit: int) -> int:
    """Read the messages of the topics chosen; return how many more bytes may follow."""
    by_name = {(raw.name, raw.message_type): raw for raw in topics.values()}
    wanted = [x for x in reader.connections if (x.topic, x.msgtype) in by_name]
    for connection in wanted:
        encoding = cast("ConnectionExtRosbag2", connection.ext).serialization_format
        if encoding != "cdr":
            raise BagError(
                f"bag {path}: topic {connection.topic} is serialized as {encoding!r}: must be cdr"
            )
    if not wanted:  # for the reader, none means all
        return limit
    found: Counter[int] = Counter()
    for connection, received, stored in reader.messages(wanted):
        raw = by_name[connection.topic, connection.msgtype]
        data = _message(path, raw, received, stored, limit)
        limit -= len(data)
        if limit < 0:
            raise BagError(f"bag {path}: holds more data than a bag of its size may")
        raw.received.append(received)
        raw.data.append(data)
        found[connection.id] += 1
    for connection in wanted:
        if found[connection.id] < connection.msgcount:
            raise BagError(
                f"bag {path}: declares {connection.msgcount} messages of {connection.topic}: "
                f"only {found[connection.id]} can be read{recovery_hint(path)}"
            )
    return limit


def _message(path: Path, raw: RawTopic, received: object, stored: object, limit: int) -> bytes:
    """Return the content of a message that may be compressed: CDR begins with another byte."""
    # sqlite holds values of any type in any column.
    if not isinstance(stored, bytes) or not isinstance(received, int):
        raise BagError(f"bag {path}: message {len(raw.data)} of {raw.name} is not binary data")
    if not stored.startswith(ZSTD_MAGIC):
        return stored
    try:
        return decompress_message(stored, min(limit, allowed_size(len(stored))))
    except BagError as error:
        raise BagError(f"bag {path}: message {len(raw.data)} of {raw.name}: {error}") from None


def _content(path: Path, readers: Sequence[Reader], topic: RecordedTopic) -> str | None:
    """Return the column labels or the joint of the first message of a topic."""
    raw = RawTopic(*topic)
    for reader in readers:
        wanted = [x for x in reader.connections if (x.topic, x.msgtype) == topic]
        for _, received, stored in islice(reader.messages(wanted), 1 if wanted else 0):
            raw.data.append(_message(path, raw, received, stored, ALWAYS_ALLOWED))
            (message,) = decode(path, raw)
            if topic.message_type == JOINT_STATE:
                return str(message.name[0]) if len(message.name) == 1 else None
            dimensions = message.layout.dim
            return str(dimensions[1].label) if len(dimensions) == 2 else None
    return None
