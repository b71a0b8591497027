"""A sqlite3 file that holds data and no program, intact and untouched."""

import sqlite3
from contextlib import closing

import pytest

from bdt_bags.bag_error import BagError
from bdt_bags.reading import sqlite_check
from bdt_bags.reading.sqlite_check import check_sqlite

TOPICS = "CREATE TABLE topics(id INTEGER, name TEXT, type TEXT, offered_qos_profiles TEXT)"
MESSAGES = "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, {})"
DATA = MESSAGES.format("data BLOB")
TOPIC = "INSERT INTO topics VALUES(1, '/telemetry', 'x', '')"
ENDLESS = (
    "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT max(x) AS n FROM c"
)


@pytest.fixture
def check(tmp_path):
    def run(*statements: str) -> None:
        with closing(sqlite3.connect(tmp_path / "x.db3")) as connection, connection:
            for statement in statements:
                connection.execute(statement)
        check_sqlite(tmp_path / "x.db3")

    return run


def test_intact(check):
    check(TOPICS, DATA, TOPIC, "INSERT INTO messages VALUES(1, 1, 5, x'00')")


@pytest.mark.parametrize(
    ("statements", "reason"),
    [
        ([TOPICS, DATA, f"CREATE VIEW schema AS {ENDLESS}"], "holds the view schema"),
        (
            [TOPICS, MESSAGES.format("data BLOB AS (zeroblob(900000000))")],
            "computes the column data of messages",
        ),
        ([TOPICS, DATA, "CREATE VIRTUAL TABLE schema USING fts5(x)"], "holds the virtual table"),
        ([TOPICS, DATA, TOPIC, TOPIC], "has 2 topics with 1 identifiers: must be as many"),
        ([DATA], "without the table topics"),
        ([TOPICS, DATA, TOPIC, "INSERT INTO messages VALUES(1, 1, 5, 'text')"], "another type"),
        ([TOPICS, DATA, TOPIC, "INSERT INTO messages VALUES(1, 1, 'x', x'00')"], "another type"),
        ([TOPICS, DATA, TOPIC, "INSERT INTO messages VALUES(1, 1, NULL, x'00')"], "another type"),
    ],
)
def test_what_no_recorder_writes(check, statements, reason):
    with pytest.raises(BagError, match=reason):
        check(*statements)


def test_a_file_that_lacks_its_last_byte_is_refused(check, tmp_path):
    """What lies behind the end sqlite takes for zeros, also in the last message."""
    check(TOPICS, DATA, TOPIC)
    path = tmp_path / "x.db3"
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(BagError, match="is cut off: has 12287 bytes of 12288"):
        check_sqlite(path)


def test_work_is_limited_by_the_size_of_the_file(check, monkeypatch):
    rows = "INSERT INTO messages WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c "
    rows += "WHERE x < 2000) SELECT x, 1, x, x'00' FROM c"
    check(TOPICS, DATA, TOPIC, rows)
    monkeypatch.setattr(sqlite_check, "_STEPS_BETWEEN_CHECKS", 10)
    monkeypatch.setattr(sqlite_check, "_STEPS_PER_BYTE", 0)
    with pytest.raises(BagError, match="is not an intact sqlite3 database: interrupted"):
        check("SELECT 1")


def test_damaged_page(check, tmp_path):
    test_intact(check)
    content = bytearray((tmp_path / "x.db3").read_bytes())
    content[4096 + 3 : 4096 + 5] = b"\xff\xff"
    (tmp_path / "x.db3").write_bytes(content)
    with pytest.raises(BagError, match="sqlite3 database"):
        check_sqlite(tmp_path / "x.db3")


def test_pages_in_a_circle(check, tmp_path):
    """An inner page of a table that names itself as its child makes the table endless."""
    rows = "INSERT INTO messages WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c "
    rows += "WHERE x < 3000) SELECT x, 1, x, x'00' FROM c"
    check(TOPICS, DATA, TOPIC, rows)
    content = bytearray((tmp_path / "x.db3").read_bytes())
    (page,) = (k for k in range(4096, len(content), 4096) if content[k] == 5)
    content[page + 8 : page + 12] = (page // 4096 + 1).to_bytes(4, "big")
    (tmp_path / "x.db3").write_bytes(content)
    with pytest.raises(BagError, match="is a damaged sqlite3 database"):
        check_sqlite(tmp_path / "x.db3")


def test_nothing_is_written_beside_it(check, tmp_path):
    test_intact(check)
    with closing(sqlite3.connect(tmp_path / "x.db3")) as connection:
        connection.execute("PRAGMA journal_mode = WAL")
    (tmp_path / "x.db3").chmod(0o444)
    before = (tmp_path.stat().st_mtime_ns, (tmp_path / "x.db3").read_bytes())
    check_sqlite(tmp_path / "x.db3")
    assert (tmp_path.stat().st_mtime_ns, (tmp_path / "x.db3").read_bytes()) == before
    assert [x.name for x in tmp_path.iterdir()] == ["x.db3"]
