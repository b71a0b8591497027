"""Reads a sqlite3 bag file with what its journal or write-ahead log holds, past damaged pages."""

import shutil
import sqlite3
from collections.abc import Iterator
from pathlib import Path

from bdt_bags.recovery.damaged_file import Damage
from bdt_bags.writing.topic_metadata import SerializedMessage, TopicMetadata, topic_metadata

COMPANIONS = ("-journal", "-wal")
"""What sqlite keeps beside a file; without it the last transaction is torn or missing."""

_ATTEMPTS = 100_000
"""Queries that may be spent on finding what can be read around damaged pages."""
_LONGEST_DATA = 1 << 30


class DamagedSqliteFile:
    """A sqlite3 file in whatever state.

    Opening a file with a journal changes it, so a copy is opened.

    Parameters
    ----------
    path : Path
        The file; it is only read.
    workspace : Path
        Folder for the copy.

    Attributes
    ----------
    topics : list of TopicMetadata
        Topics declared in the file.
    damage : Damage
        What was not understood; complete when :meth:`messages` is exhausted.
    compression : str
        Always ``none``.

    Raises
    ------
    OSError
        If the file cannot be read or copied.
    """

    def __init__(self, path: Path, workspace: Path) -> None:
        self.topics: list[TopicMetadata] = []
        self.damage = Damage()
        self.compression = "none"
        self._numbers: dict[int, int] = {}
        self._copy = workspace / path.name
        shutil.copyfile(path, self._copy)
        for companion in COMPANIONS:
            beside = path.with_name(path.name + companion)
            if beside.exists():
                shutil.copyfile(beside, self._copy.with_name(self._copy.name + companion))
        self._connection = sqlite3.connect(self._copy, isolation_level=None)
        self._connection.text_factory = lambda text: text.decode(errors="replace")
        try:
            # Reads a file that is shorter than its first page says.
            self._connection.execute("PRAGMA writable_schema = ON")
            # One transaction for all queries: sqlite need not look for changes before each.
            self._connection.execute("BEGIN")
            self._find_topics()
        except sqlite3.Error as error:
            self.damage.note(f"topics cannot be read: {error}")

    def messages(self) -> Iterator[SerializedMessage]:
        """Iterate over the messages in the order in which they were recorded."""
        for identifier, topic, received, data in self._rows():
            number = self._numbers.get(topic)
            if number is None:
                self.damage.note(f"message {identifier} is of an unknown topic {topic!r}")
            elif not isinstance(received, int) or not isinstance(data, bytes):
                self.damage.note(f"message {identifier} has no time or no content")
            else:
                yield SerializedMessage(number, received, received, data)
        self._connection.close()

    def _find_topics(self) -> None:
        columns = {row[1] for row in self._connection.execute("PRAGMA table_info(topics)")}
        # Older recorders did not write these.
        offered = "offered_qos_profiles" if "offered_qos_profiles" in columns else "''"
        type_hash = "type_description_hash" if "type_description_hash" in columns else "''"
        definitions = self._definitions()
        for row in self._connection.execute(
            f"SELECT id, name, type, serialization_format, {offered}, {type_hash} FROM topics"  # noqa: S608
        ):
            identifier, *texts = row
            if not all(isinstance(text, str) for text in texts) or not texts[0]:
                self.damage.note(f"topic {identifier} is damaged")
                continue
            name, message_type, serialization, qos, digest = texts
            if message_type in definitions:
                encoding, definition = definitions[message_type]
                topic = TopicMetadata(
                    name, message_type, definition, digest, qos, encoding, serialization
                )
            else:
                topic = _defined_by_jazzy(name, message_type, qos)
            self._numbers[identifier] = len(self.topics)
            self.topics.append(topic)

    def _definitions(self) -> dict[str, tuple[str, str]]:
        try:
            rows = self._connection.execute(
                "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
            ).fetchall()
        except sqlite3.Error:
            # A file of an older recorder has no such table.
            return {}
        return {
            kind: (encoding, text)
            for kind, encoding, text in rows
            if isinstance(encoding, str) and isinstance(text, str)
        }

    def _rows(self) -> Iterator[tuple[int, int, object, object]]:
        """Iterate over all rows that can be read; damaged pages are closed in on by halves."""
        last = self._last_identifier()
        ranges = [(-(2**63), last)]
        attempts = 0
        while ranges:
            low, high = ranges.pop()
            try:
                for row in self._connection.execute(
                    "SELECT id, topic_id, timestamp, data FROM messages "
                    "WHERE id BETWEEN ? AND ? ORDER BY id",
                    (low, high),
                ):
                    low = row[0] + 1
                    yield row
            except (sqlite3.Error, OverflowError, MemoryError) as error:
                attempts += 1
                if low < 0 or attempts == 1:
                    self.damage.note(f"messages from {max(low, 0)} on: {error}")
                low = max(low, 0)
                if attempts == _ATTEMPTS:
                    self.damage.note("too much is damaged: what lies within is left out")
                if attempts >= _ATTEMPTS or low >= high:
                    continue
                middle = (low + high) // 2
                # The part that is read next stands last.
                ranges += [(middle + 1, high), (low, middle)]

    def _last_identifier(self) -> int:
        try:
            found = self._connection.execute("SELECT max(id) FROM messages").fetchone()[0]
        except sqlite3.Error:
            found = None
        # No row takes less than ten bytes.
        return found if isinstance(found, int) else self._copy.stat().st_size // 10


def _defined_by_jazzy(name: str, message_type: str, offered_qos: str) -> TopicMetadata:
    try:
        return topic_metadata(name, message_type, offered_qos)
    except ValueError:
        return TopicMetadata(name, message_type, "", "", offered_qos)
