"""Reads a sqlite3 bag file with what its journal or write-ahead log holds, past damaged pages.

An intact file is read by sqlite, a damaged one page by page: the tree of a damaged file can lead
sqlite in circles.
"""

import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

from bdt_bags.bag_error import BagError, one_line
from bdt_bags.reading.sqlite_check import check_sqlite
from bdt_bags.recovery.damaged_file import Damage
from bdt_bags.recovery.sqlite_log import apply_log
from bdt_bags.recovery.sqlite_pages import Row, SqlitePages
from bdt_bags.writing.topic_metadata import SerializedMessage, TopicMetadata, topic_metadata

_NAMES_ANOTHER_JOURNAL = bytes.fromhex("d9d505f920a163d7")
"""End of a journal of several files; to roll back with it, sqlite deletes a file that it names."""


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
        self._roll_back(path.with_name(f"{path.name}-journal"))
        log = path.with_name(f"{path.name}-wal")
        if log.exists():
            apply_log(self._copy, log, self.damage)
        self._pages: SqlitePages | None = None
        try:
            check_sqlite(self._copy)
            with closing(sqlite3.connect(self._copy)) as connection:
                self._find_topics(_described_topics(connection), _definitions(connection))
        except (BagError, sqlite3.Error) as error:
            self.damage.note(f"read page by page: {one_line(error)}")
            self._pages = SqlitePages(self._copy)
            if missing := self._pages.missing_pages():
                self.damage.note(f"the file lacks the last {missing} of its pages")
            self._find_topics(*_descriptions_in(self._pages))

    def messages(self) -> Iterator[SerializedMessage]:
        """Iterate over the messages in the order in which they were recorded."""
        pages = self._pages
        for identifier, values in self._rows() if pages is None else self._rows_of_pages(pages):
            topic, received, data = values[-3:]
            number = self._numbers.get(topic) if isinstance(topic, int) else None
            if number is None:
                self.damage.note(f"message {identifier} is of an unknown topic {topic!r}")
            elif not isinstance(received, int) or not isinstance(data, bytes):
                self.damage.note(f"message {identifier} has no time or no content")
            else:
                yield SerializedMessage(number, received, received, data)

    def _roll_back(self, journal: Path) -> None:
        """Undo the transaction that was under way, which a journal tells."""
        if not journal.exists():
            return
        if journal.read_bytes().endswith(_NAMES_ANOTHER_JOURNAL):
            self.damage.note("the journal is left out: it is that of several files")
            return
        shutil.copyfile(journal, self._copy.with_name(f"{self._copy.name}-journal"))
        try:
            with closing(sqlite3.connect(self._copy)) as connection:
                connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
        except sqlite3.Error as error:
            self.damage.note(f"the journal cannot be read: {error}")

    def _find_topics(self, topics: list[Row], definitions: list[Row]) -> None:
        texts = {row.values[1]: (row.values[2], row.values[3]) for row in definitions}
        for identifier, (_, *columns) in topics:
            # Older recorders did not write the last two.
            name, message_type, serialization, qos, digest = (*columns, "", "")[:5]
            if not (
                isinstance(name, str)
                and isinstance(message_type, str)
                and isinstance(serialization, str)
                and isinstance(qos, str)
                and isinstance(digest, str)
                and name
            ):
                self.damage.note(f"topic {identifier} is damaged")
                continue
            encoding, definition = texts.get(message_type, (None, None))
            if isinstance(encoding, str) and isinstance(definition, str):
                topic = TopicMetadata(
                    name, message_type, definition, digest, qos, encoding, serialization
                )
            else:
                topic = _defined_by_jazzy(name, message_type, qos)
            self._numbers[identifier] = len(self.topics)
            self.topics.append(topic)

    def _rows(self) -> Iterator[Row]:
        with closing(sqlite3.connect(self._copy)) as connection:
            for identifier, *values in connection.execute(
                "SELECT id, topic_id, timestamp, data FROM messages ORDER BY id"
            ):
                yield Row(identifier, tuple(values))

    def _rows_of_pages(self, pages: SqlitePages) -> Iterator[Row]:
        """Iterate over the messages of all pages.

        Pages are in the order of the middle one of their rows, rows in that of their page: a
        number that is damaged misplaces nothing.
        """
        order = []
        for page in pages.leaves():
            numbers = sorted(row.identifier for row in page.rows if _is_message(row))
            if numbers:
                order.append((numbers[len(numbers) // 2], page.place))
            elif page.torn:
                self.damage.note(f"page at byte {page.place}: {page.torn} rows are damaged")
        pages.begin_anew()
        for _, place in sorted(order):
            page = pages.leaf(place)
            if page.torn:
                self.damage.note(f"page at byte {place}: {page.torn} rows are damaged")
            yield from filter(_is_message, page.rows)
        if unknown := pages.unknown_pages():
            self.damage.note(f"{unknown} pages are damaged", unknown * pages.page_size)


def _is_message(row: Row) -> bool:
    if len(row.values) != 4:
        return False
    none, topic, received, data = row.values
    whole = isinstance(topic, int) and isinstance(received, int) and isinstance(data, bytes)
    return none is None and whole


def _descriptions_in(pages: SqlitePages) -> tuple[list[Row], list[Row]]:
    """Return the rows that describe topics and those that define messages."""
    topics, definitions = [], []
    for page in pages.leaves():
        for row in page.rows:
            texts = row.values[1:]
            if row.values[:1] != (None,) or not all(isinstance(text, str) for text in texts):
                continue
            if len(texts) >= 3 and str(texts[0]).startswith("/"):
                topics.append(row)
            elif len(texts) >= 3:
                definitions.append(row)
    return topics, definitions


def _described_topics(connection: sqlite3.Connection) -> list[Row]:
    columns = {row[1] for row in connection.execute("PRAGMA table_info(topics)")}
    # Older recorders did not write these.
    offered = "offered_qos_profiles" if "offered_qos_profiles" in columns else "''"
    type_hash = "type_description_hash" if "type_description_hash" in columns else "''"
    found = connection.execute(
        f"SELECT id, name, type, serialization_format, {offered}, {type_hash} FROM topics"  # noqa: S608
    )
    return [Row(identifier, (None, *texts)) for identifier, *texts in found]


def _definitions(connection: sqlite3.Connection) -> list[Row]:
    if not connection.execute("PRAGMA table_info(message_definitions)").fetchall():
        # A file of an older recorder has no such table.
        return []
    found = connection.execute(
        "SELECT id, topic_type, encoding, encoded_message_definition FROM message_definitions"
    )
    return [Row(identifier, (None, *texts)) for identifier, *texts in found]


def _defined_by_jazzy(name: str, message_type: str, offered_qos: str) -> TopicMetadata:
    try:
        return topic_metadata(name, message_type, offered_qos)
    except ValueError:
        return TopicMetadata(name, message_type, "", "", offered_qos)
