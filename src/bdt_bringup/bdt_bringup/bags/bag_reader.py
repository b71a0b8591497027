"""Bags: find the project's topics in any rosbag2 recording and take out their raw messages.

Reading is by ``rosbags`` alone, so a bag can be looked at where there is no ROS. The bag is only
ever opened for reading.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from rosbags.interfaces import Connection
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    COMMAND,
    DIAGNOSTICS,
    MEASUREMENT,
    PARAMETER_EVENTS,
    REFERENCE,
    TELEMETRY,
    TRUTH,
    Topic,
)

REQUIRED = (TELEMETRY, REFERENCE)
OPTIONAL = (TRUTH, BACKLASH_ESTIMATE, MEASUREMENT, COMMAND, PARAMETER_EVENTS, DIAGNOSTICS)


class BagError(ValueError):
    """A bag or an output folder cannot be used; one line that says why and what is required."""


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
    """

    name: str
    message_type: str
    received: list[int] = field(default_factory=list)
    data: list[bytes] = field(default_factory=list)

    @property
    def namespace(self) -> str:
        """Return what stands before the last name component, without the last slash."""
        return self.name.rpartition("/")[0]


@dataclass(frozen=True)
class RawBag:
    """What the analysis takes from a bag.

    Attributes
    ----------
    path : Path
        The bag.
    topics : mapping of Topic to RawTopic
        The topics of the public interface that were found; the required ones always.
    message_counts : mapping of str to int
        Number of messages of every topic in the bag, by its name there.
    """

    path: Path
    topics: Mapping[Topic, RawTopic]
    message_counts: Mapping[str, int]


def read_bag(path: Path) -> RawBag:
    """Read the raw messages of the project's topics.

    Parameters
    ----------
    path : Path
        A rosbag2 folder (mcap or sqlite3, compressed or not) or a bare ``.mcap`` or ``.db3`` file.

    Raises
    ------
    BagError
        If this is not a readable bag, or if it lacks a required topic.
    """
    path = Path(path)
    _check_path(path)
    try:
        with Reader(path) as reader:
            counts: dict[str, int] = {}
            for connection in reader.connections:
                counts[connection.topic] = counts.get(connection.topic, 0) + connection.msgcount
            names = find_topics(path, reader.connections)
            topics = {topic: RawTopic(name, topic.message_type) for topic, name in names.items()}
            _fill(reader, topics)
    except BagError:
        raise
    except MemoryError:
        raise BagError(f"bag {path}: declares more data than fits in memory") from None
    except Exception as error:
        # A damaged file makes rosbags and the parsers below it raise nearly anything.
        raise BagError(f"bag {path}: is not a readable rosbag2 bag: {one_line(error)}") from error
    for topic in REQUIRED:
        if not topics[topic].data:
            raise BagError(
                f"bag {path}: topic {topics[topic].name} has no messages: must have at least one"
            )
    counts.update({raw.name: len(raw.data) for raw in topics.values()})
    return RawBag(path, topics, dict(sorted(counts.items())))


def find_topics(path: Path, connections: list[Connection]) -> dict[Topic, str]:
    """Find the project's topics by their last name component and message type.

    When a topic occurs in several namespaces, the one beside the telemetry is meant.

    Parameters
    ----------
    path : Path
        The bag, for messages.
    connections : list of Connection
        All connections of the bag.

    Returns
    -------
    dict of Topic to str
        Full names; topics that are optional and not there are left out.

    Raises
    ------
    BagError
        If a required topic is missing or of the wrong type, or if it is unclear which one is meant.
    """
    found: dict[Topic, str] = {}
    for topic in (*REQUIRED, *OPTIONAL):
        component = _last_component(topic.name)
        types = {x.topic: x.msgtype for x in connections if _last_component(x.topic) == component}
        names = sorted(name for name, type_ in types.items() if type_ == topic.message_type)
        if not names and topic in REQUIRED:
            if types:
                name, type_ = min(types.items())
                raise BagError(
                    f"bag {path}: topic {name} has type {type_}: must be {topic.message_type}"
                )
            raise BagError(
                f"bag {path}: lacks topic {component} ({topic.message_type}); it has "
                + (", ".join(sorted({x.topic for x in connections})[:20]) or "no topics")
            )
        if len(names) > 1 and topic is not TELEMETRY:
            namespace = found[TELEMETRY].rpartition("/")[0]
            names = [name for name in names if name.rpartition("/")[0] == namespace] or names
        if len(names) > 1:
            raise BagError(
                f"bag {path}: {' and '.join(names)} could both be the topic {component}: "
                "must hold one loop"
            )
        if names:
            found[topic] = names[0]
    return found


def decode(path: Path, raw: RawTopic) -> list[Any]:
    """Return the messages of a topic as objects.

    Raises
    ------
    BagError
        If one is damaged.
    """
    store = typestore()
    messages = []
    for number, data in enumerate(raw.data):
        try:
            messages.append(store.deserialize_cdr(data, raw.message_type))
        except Exception as error:
            raise BagError(
                f"bag {path}: message {number} of {raw.name} is damaged: {one_line(error)}"
            ) from error
    return messages


@cache
def typestore() -> Typestore:
    """Return the message definitions of ROS 2 Jazzy."""
    return get_typestore(Stores.ROS2_JAZZY)


def one_line(error: BaseException) -> str:
    """Return what an exception says, in one line that is never empty."""
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= 300 else text[:297] + "..."


def _check_path(path: Path) -> None:
    try:
        if not path.exists():
            raise BagError(f"bag {path}: does not exist")
        if path.is_dir() and not (path / "metadata.yaml").is_file():
            files = sorted(x.name for x in path.iterdir() if x.suffix in {".mcap", ".db3"})
            hint = f"; {path / files[0]} can be given by itself" if files else ""
            raise BagError(
                f"bag {path}: has no metadata.yaml: must be a rosbag2 folder, "
                f"a .mcap or a .db3 file{hint}"
            )
        if path.is_file() and path.suffix not in {".mcap", ".db3"}:
            raise BagError(f"bag {path}: must be a rosbag2 folder, a .mcap or a .db3 file")
    except OSError as error:
        raise BagError(f"bag {path}: cannot be read: {error.strerror or error}") from None


def _fill(reader: Reader, topics: Mapping[Topic, RawTopic]) -> None:
    """Read the messages of the topics found, and nothing else."""
    by_name = {(raw.name, raw.message_type): raw for raw in topics.values()}
    wanted = [x for x in reader.connections if (x.topic, x.msgtype) in by_name]
    for connection, received, data in reader.messages(wanted):
        raw = by_name[connection.topic, connection.msgtype]
        raw.received.append(received)
        raw.data.append(data)


def _last_component(name: str) -> str:
    return name.rpartition("/")[2]
