"""A sqlite3 file, checked before it is read: intact, only tables, work in proportion to its size.

sqlite checks sizes itself, but a schema is a program: a view or a generated column can compute for
ever, and pages that refer to each other in a circle make a short file endless.
"""

import sqlite3
from contextlib import closing
from pathlib import Path

from bdt_bags.bag_error import BagError, one_line

LARGEST_DESCRIPTIONS = 5000
"""Number of topics, and of message definitions; a reader compares all with all."""

LARGEST_PROFILES = 2**20
"""Size of all quality of service profiles [bytes]: YAML, of which 0.2 MB are read in a second."""

_STEPS_BETWEEN_CHECKS = 100_000
_STEPS_PER_BYTE = 50
"""A row of a message takes at least 20 bytes and about 100 steps of sqlite's virtual machine."""

_TABLES = ("messages", "topics", "schema", "message_definitions")


def check_sqlite(path: Path) -> None:
    """Check a sqlite3 file without writing beside it.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    BagError
        If it is damaged or holds what no recorder writes.
    """
    size = path.stat().st_size
    uri = f"{path.resolve().as_uri()}?mode=ro&immutable=1"
    try:
        with closing(sqlite3.connect(uri, uri=True)) as connection:
            connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, max(size, 2**20))
            _limit_work(connection, size)
            _check_size(connection, size)
            _check_schema(connection)
            _check_content(connection)
    except (sqlite3.Error, UnicodeDecodeError) as error:
        # The second one comes from names that are no text.
        raise BagError(f"is not an intact sqlite3 database: {one_line(error)}") from None


def _limit_work(connection: sqlite3.Connection, size: int) -> None:
    left = 100 + size * _STEPS_PER_BYTE // _STEPS_BETWEEN_CHECKS

    def interrupt() -> bool:
        nonlocal left
        left -= 1
        return left < 0

    connection.set_progress_handler(interrupt, _STEPS_BETWEEN_CHECKS)


def _check_size(connection: sqlite3.Connection, size: int) -> None:
    """Refuse a file that ends too early: sqlite takes what a page lacks for zeros."""
    pages, page_size = (
        int(connection.execute(f"PRAGMA {name}").fetchone()[0])
        for name in ("page_count", "page_size")
    )
    if size < pages * page_size:
        raise BagError(f"is cut off: has {size} bytes of {pages * page_size}")


def _check_schema(connection: sqlite3.Connection) -> None:
    """Refuse what computes instead of holding."""
    for kind, name, statement in connection.execute("SELECT type, name, sql FROM sqlite_master"):
        virtual = kind == "table" and "virtual" in str(statement).lower().split()[:2]
        if kind not in {"table", "index"} or virtual:
            raise BagError(f"holds the {'virtual ' if virtual else ''}{kind} {name}: must not")
    for table in _TABLES:
        for _, column, *_, hidden in connection.execute(f"PRAGMA table_xinfo({table})"):
            if hidden:
                raise BagError(f"computes the column {column} of {table}: must hold it")


def _check_content(connection: sqlite3.Connection) -> None:
    (verdict,) = connection.execute("PRAGMA quick_check(1)").fetchone()
    if verdict != "ok":
        raise BagError(f"is a damaged sqlite3 database: {verdict}")
    columns = {row[1] for row in connection.execute("PRAGMA table_info(topics)")}
    if not columns:
        raise BagError("is a sqlite3 database without the table topics: is no bag")
    topics, identifiers = _counts(connection, "count(*), count(DISTINCT id) FROM topics")
    if topics != identifiers or topics > LARGEST_DESCRIPTIONS:
        raise BagError(
            f"has {topics} topics with {identifiers} identifiers: must be as many, "
            f"{LARGEST_DESCRIPTIONS} at most"
        )
    if "offered_qos_profiles" in columns:
        (profiles,) = _counts(
            connection, "coalesce(sum(length(offered_qos_profiles)), 0) FROM topics"
        )
        if profiles > LARGEST_PROFILES:
            raise BagError(
                f"has {profiles} bytes of quality of service: must be {LARGEST_PROFILES} or less"
            )
    (others,) = _counts(
        connection,
        "count(*) FROM messages WHERE typeof(timestamp) != 'integer' OR typeof(data) != 'blob'",
    )
    if others:
        raise BagError(f"has {others} messages whose time or data is of another type: must not")
    if connection.execute("PRAGMA table_info(message_definitions)").fetchall():
        (definitions,) = _counts(connection, "count(*) FROM message_definitions")
        if definitions > LARGEST_DESCRIPTIONS:
            raise BagError(
                f"has {definitions} message definitions: must be {LARGEST_DESCRIPTIONS} or less"
            )


def _counts(connection: sqlite3.Connection, what: str) -> tuple[int, ...]:
    row: tuple[int, ...] = connection.execute(f"SELECT {what}").fetchone()
    return row
