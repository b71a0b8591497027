"""A sqlite3 file of a bag, schema version 4; each commit is a transaction in its log."""

import os
import sqlite3
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bdt_bags.bag_format import NEWEST_VERSION
from bdt_bags.writing.metadata_file import metadata_text
from bdt_bags.writing.topic_metadata import BagWriteError, SerializedMessage, TopicMetadata

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

_LONGEST_LOG = 4 << 20
"""Size above which what stands in the log is carried into the file [byte]."""


class SqliteFile:
    """Writes one sqlite3 file.

    While it is written, what is committed stands in a write-ahead log beside it: to append there
    takes no sync, so that a commit hands messages to the system at once, however slow the disk
    is. What is synced goes from the log into the file from time to time. A file that was finished
    has no log.

    Parameters
    ----------
    path : Path
        File, which must not exist.
    topics : sequence of TopicMetadata
        Topics of the bag; more may be appended while the file is open.

    Raises
    ------
    BagWriteError
        If the file cannot be created.
    """

    suffix = ".db3"

    def __init__(self, path: Path, topics: Sequence[TopicMetadata]) -> None:
        self.path = path
        self._log = path.with_name(f"{path.name}-wal")
        self._topics = topics
        self._registered = 0
        self._waiting: list[SerializedMessage] = []
        self._open = threading.Lock()
        self._closed = self._moved = self._described = False
        self._descriptor = -1
        self._mover: sqlite3.Connection | None = None
        if path.exists():
            raise BagWriteError("exists already")
        try:
            self._connection = _connect(path)
        except sqlite3.Error as error:
            raise BagWriteError(str(error)) from error
        try:
            # Before the first sync, which carries all of it to the disk, there is nothing to keep.
            self._connection.execute("PRAGMA synchronous = OFF")
            self._connection.execute("PRAGMA journal_mode = WAL")
            self._connection.execute("PRAGMA wal_autocheckpoint = 0")
            self._connection.executescript(_SCHEMA)
            # The one sync of a commit from here on: a log that begins anew, because all of it has
            # gone into the file, must say so on the disk before it is written over.
            self._connection.execute("PRAGMA synchronous = NORMAL")
            self._page_size = int(self._connection.execute("PRAGMA page_size").fetchone()[0])
            self._descriptor = os.open(self._log, os.O_RDONLY)
        except (sqlite3.Error, OSError) as error:
            self._connection.close()
            for leftover in (path, self._log):
                leftover.unlink(missing_ok=True)
            raise BagWriteError(str(error)) from error

    @property
    def size(self) -> int:
        """Size of the file [byte], with what it will take from its log."""
        pages = self._connection.execute("PRAGMA page_count").fetchone()[0]
        return int(pages) * self._page_size

    def append(self, messages: Sequence[SerializedMessage]) -> None:
        """Take messages; nothing reaches the disk before :meth:`commit`."""
        self._waiting += messages

    def commit(self) -> None:
        """Hand to the system what was appended, all or nothing.

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
        """Carry to the disk itself what was committed, so that it survives a power cut.

        May run in another thread than the rest.

        Raises
        ------
        BagWriteError
            If the disk refuses.
        """
        with self._open:
            if self._closed:
                return
            try:
                if not self._moved or os.fstat(self._descriptor).st_size > _LONGEST_LOG:
                    self._move_log()
                else:
                    os.fdatasync(self._descriptor)
            except OSError as error:
                raise BagWriteError(error.strerror) from error
            except sqlite3.Error as error:
                raise BagWriteError(str(error)) from error

    def _move_log(self) -> None:
        """Sync the log and carry into the file what stands there; commits go on meanwhile."""
        if self._mover is None:
            self._mover = _connect(self.path)
            self._mover.execute("PRAGMA synchronous = NORMAL")
        self._mover.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchone()
        self._moved = True

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
            if not self._described:
                with self._connection:
                    self._connection.execute("BEGIN")
                    self._connection.execute(
                        "INSERT INTO metadata (metadata_version, metadata) VALUES (?, ?)",
                        (NEWEST_VERSION, metadata_text(information)),
                    )
                self._described = True
            with self._open:
                self._close_mover()
                # EXTRA: what was said to be on the disk stays there after a power cut.
                self._connection.execute("PRAGMA synchronous = EXTRA")
                self._connection.execute("PRAGMA journal_mode = DELETE").fetchone()
        except sqlite3.Error as error:
            raise BagWriteError(str(error)) from error
        self._close()

    def abandon(self) -> None:
        """Close the file as it is after the last commit."""
        self._close()

    def _close(self) -> None:
        with self._open:
            if self._closed:
                return
            self._closed = True
            self._close_mover()
            self._connection.close()
            os.close(self._descriptor)

    def _close_mover(self) -> None:
        mover, self._mover = self._mover, None
        if mover is not None:
            mover.close()

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


def _connect(path: Path) -> sqlite3.Connection:
    return sqlite3.connect(path, isolation_level=None, check_same_thread=False, timeout=0.0)
