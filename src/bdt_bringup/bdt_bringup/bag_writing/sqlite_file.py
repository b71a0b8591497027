"""A sqlite3 file of a bag, schema version 4; each commit is a transaction."""

import sqlite3
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bdt_bringup.bag_writing.metadata_file import VERSION, metadata_text
from bdt_bringup.bag_writing.recorded_topic import BagWriteError, Message, RecordedTopic

_SCHEMA = """
BEGIN;
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(
  id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
CREATE TABLE topics(
  id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
  serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL,
  type_description_hash TEXT NOT NULL);
CREATE TABLE message_definitions(
  id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
  encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE messages(
  id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
  data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
INSERT INTO schema(schema_version, ros_distro) VALUES (4, 'jazzy');
COMMIT;
"""


class SqliteFile:
    """Writes one sqlite3 file.

    The rollback journal keeps the file itself readable between two commits, even for readers that
    do not look for a journal; a write-ahead log would not.

    Parameters
    ----------
    path : Path
        File, which must not exist.
    topics : sequence of RecordedTopic
        Topics of the bag; more may be appended while the file is open.

    Raises
    ------
    BagWriteError
        If the file cannot be created.
    """

    suffix = ".db3"

    def __init__(self, path: Path, topics: Sequence[RecordedTopic]) -> None:
        self.path = path
        self._topics = topics
        self._registered = 0
        self._waiting: list[Message] = []
        if path.exists():
            raise BagWriteError("exists already")
        try:
            self._connection = sqlite3.connect(
                path, isolation_level=None, check_same_thread=False, timeout=0.0
            )
        except sqlite3.Error as error:
            raise BagWriteError(str(error)) from error
        try:
            # EXTRA: a transaction that was committed stays so after a power cut.
            self._connection.execute("PRAGMA synchronous = EXTRA")
            self._connection.executescript(_SCHEMA)
        except sqlite3.Error as error:
            self._connection.close()
            path.unlink(missing_ok=True)
            raise BagWriteError(str(error)) from error

    @property
    def size(self) -> int:
        """Size of the file [byte]."""
        return self.path.stat().st_size

    def append(self, messages: Sequence[Message]) -> None:
        """Take messages; nothing reaches the disk before :meth:`commit`."""
        self._waiting += messages

    def commit(self) -> None:
        """Write what was appended, all or nothing, and make it survive a power cut.

        Raises
        ------
        BagWriteError
            If the disk refuses; what was appended is kept for the next commit.
        """
        if not self._waiting and self._registered == len(self._topics):
            return
        topics = len(self._topics)
        try:
            with self._connection:
                self._connection.execute("BEGIN")
                self._register_topics(topics)
                self._connection.executemany(
                    "INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)",
                    ((1 + topic, received, data) for topic, received, _, data in self._waiting),
                )
        except sqlite3.Error as error:
            raise BagWriteError(str(error)) from error
        self._registered = topics
        self._waiting.clear()

    def sync(self) -> None:
        """Do nothing: a commit has carried everything to the disk itself."""

    def finish(self, information: dict[str, Any]) -> None:
        """Write the description of the bag and close the file; may be repeated after a failure.

        Parameters
        ----------
        information : dict
            See :func:`describe_bag`.

        Raises
        ------
        BagWriteError
            If the disk refuses.
        """
        self.commit()
        try:
            with self._connection:
                self._connection.execute("BEGIN")
                self._connection.execute(
                    "INSERT INTO metadata (metadata_version, metadata) VALUES (?, ?)",
                    (VERSION, metadata_text(information)),
                )
        except sqlite3.Error as error:
            raise BagWriteError(str(error)) from error
        self._connection.close()

    def abandon(self) -> None:
        """Close the file as it is after the last commit."""
        self._connection.close()

    def _register_topics(self, count: int) -> None:
        known = {topic.message_type for topic in self._topics[: self._registered]}
        for number in range(self._registered, count):
            topic = self._topics[number]
            self._connection.execute(
                "INSERT INTO topics VALUES (?, ?, ?, ?, ?, ?)",
                (
                    1 + number,
                    topic.name,
                    topic.message_type,
                    topic.serialization_format,
                    topic.offered_qos,
                    topic.type_hash,
                ),
            )
            if topic.message_type not in known:
                known.add(topic.message_type)
                self._connection.execute(
                    "INSERT INTO message_definitions (topic_type, encoding, "
                    "encoded_message_definition, type_description_hash) VALUES (?, ?, ?, ?)",
                    (
                        topic.message_type,
                        topic.definition_encoding,
                        topic.definition,
                        topic.type_hash,
                    ),
                )
