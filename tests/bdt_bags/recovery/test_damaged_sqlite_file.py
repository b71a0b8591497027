"""A sqlite3 file is read with its journal or log, past damaged pages, and is left as it is."""

import shutil
import sqlite3
import struct
from itertools import islice
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest

from bdt_bags.recovery.damaged_sqlite_file import DamagedSqliteFile

OLD_SCHEMA = """
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
  serialization_format TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,
  timestamp INTEGER NOT NULL, data BLOB NOT NULL);
INSERT INTO topics VALUES (1, '/text', 'std_msgs/msg/String', 'cdr');
"""


@pytest.fixture
def salvage(tmp_path):
    workspace = tmp_path / "workspace"
    workspace.mkdir()

    def run(path):
        before = contents_of(path)
        salvaged = DamagedSqliteFile(path, workspace)
        found = list(salvaged.messages())
        assert contents_of(path) == before
        return salvaged, found

    return run


def new_folder(parent):
    return Path(mkdtemp(dir=parent))


def contents_of(path):
    return {file.name: file.read_bytes() for file in path.parent.glob(f"{path.name}*")}


def copy_of_open(path, folder):
    """Copy a file with its journal or log, as a crash leaves them."""
    folder.mkdir()
    for file in path.parent.glob(f"{path.name}*"):
        if not file.name.endswith("-shm"):
            shutil.copyfile(file, folder / file.name)
    return folder / path.name


def write_old_bag(path, count):
    """Write a bag as early recorders did, in one transaction."""
    connection = sqlite3.connect(path, isolation_level=None)
    connection.executescript(OLD_SCHEMA)
    connection.execute("BEGIN")
    insert(connection, 0, count)
    connection.execute("COMMIT")
    connection.close()


def insert(connection, begin, end):
    connection.executemany(
        "INSERT INTO messages (topic_id, timestamp, data) VALUES (1, ?, ?)",
        ((number, number.to_bytes(4, "little") * 50) for number in range(begin, end)),
    )


def test_a_whole_file_gives_all_and_no_remarks(small_bag, small_messages, salvage):
    salvaged, found = salvage(small_bag(storage="sqlite3") / "bag_0.db3")
    assert found == small_messages
    assert [topic.message_type for topic in salvaged.topics] == [
        "std_msgs/msg/String",
        "std_msgs/msg/Header",
    ]
    assert salvaged.topics[0].type_hash.startswith("RIHS01_")
    assert salvaged.damage.remarks == []


def test_messages_in_a_write_ahead_log_are_recovered(tmp_path, salvage):
    path = tmp_path / "bag.db3"
    connection = sqlite3.connect(path, isolation_level=None)
    connection.execute("PRAGMA journal_mode = WAL")
    connection.executescript(OLD_SCHEMA)
    connection.execute("BEGIN")
    insert(connection, 0, 500)
    connection.execute("COMMIT")
    crashed = copy_of_open(path, tmp_path / "crashed")
    connection.close()
    assert crashed.with_name("bag.db3-wal").stat().st_size > 100_000
    salvaged, found = salvage(crashed)
    assert [one.received for one in found] == list(range(500))
    assert salvaged.topics[0].definition.startswith("string data")


def test_half_a_transaction_is_rolled_back(tmp_path, salvage):
    path = tmp_path / "bag.db3"
    write_old_bag(path, 300)
    connection = sqlite3.connect(path, isolation_level=None)
    # A small cache makes sqlite write pages before the transaction ends.
    connection.execute("PRAGMA cache_size = 5")
    connection.execute("BEGIN")
    connection.execute("UPDATE messages SET timestamp = timestamp + 1000")
    insert(connection, 300, 600)
    crashed = copy_of_open(path, tmp_path / "crashed")
    connection.execute("ROLLBACK")
    connection.close()
    assert crashed.with_name("bag.db3-journal").stat().st_size > 0
    _, found = salvage(crashed)
    assert [one.received for one in found] == list(range(300))


def test_what_lies_around_a_damaged_page_is_recovered(tmp_path, salvage):
    path = tmp_path / "bag.db3"
    write_old_bag(path, 2000)
    data = bytearray(path.read_bytes())
    page = 4096 * (len(data) // 4096 // 2)
    data[page : page + 4096] = bytes(4096)
    path.write_bytes(data)
    salvaged, found = salvage(path)
    numbers = [one.received for one in found]
    assert numbers == sorted(set(numbers))
    assert 1960 < len(numbers) < 2000
    assert {0, 1999} <= set(numbers)
    assert salvaged.damage.remarks[0].startswith("read page by page: is a damaged sqlite3")
    assert salvaged.damage.byte_count == 4096


def test_a_file_that_was_cut_gives_its_beginning(tmp_path, salvage):
    path = tmp_path / "bag.db3"
    write_old_bag(path, 2000)
    data = path.read_bytes()
    for part in (0.9, 0.5, 0.51234):
        path.write_bytes(data[: round(len(data) * part)])
        _, found = salvage(path)
        numbers = [one.received for one in found]
        assert numbers == sorted(set(numbers))
        assert len(numbers) > 2000 * part - 150


def test_a_cut_at_whatever_length_gives_what_is_before_it_and_nothing_else(tmp_path):
    """The rest of a page that was cut reads as zeros, which look like rows of number 0."""
    path = tmp_path / "bag.db3"
    write_old_bag(path, 500)
    data = path.read_bytes()
    for page in range(1, len(data) // 4096):
        for length in (1, 20, 100, 1000, 4000):
            path.write_bytes(data[: 4096 * page + length])
            found = list(islice(DamagedSqliteFile(path, new_folder(tmp_path)).messages(), 1000))
            numbers = [one.received for one in found]
            assert numbers == sorted(set(numbers))
            assert all(one.data == one.received.to_bytes(4, "little") * 50 for one in found)
            # Those of whole pages are all there; a row takes 200 bytes and a little more.
            begin = (page - 4) * 4096 // 230
            assert numbers[:begin] == list(range(begin))


def test_a_flipped_bit_costs_no_more_than_the_rows_of_a_page(tmp_path, salvage):
    path = tmp_path / "bag.db3"
    write_old_bag(path, 2000)
    data = path.read_bytes()
    bits = np.random.default_rng(6)
    for _ in range(100):
        flipped = bytearray(data)
        flipped[bits.integers(8192, len(data))] ^= 1 << bits.integers(8)
        path.write_bytes(flipped)
        _, found = salvage(path)
        assert 1975 < len(found) <= 2000
        # A time may be the very thing that is damaged.
        times = np.array([one.received for one in found])
        assert np.sum(np.diff(times) < 0) <= 1


def test_rows_that_go_on_in_other_pages_are_recovered(tmp_path, salvage):
    path = tmp_path / "bag.db3"
    write_old_bag(path, 1)
    connection = sqlite3.connect(path)
    contents = [bytes([number]) * (4060 + 7 * number) for number in range(250)]
    with connection:
        connection.executemany(
            "INSERT INTO messages (topic_id, timestamp, data) VALUES (1, ?, ?)", enumerate(contents)
        )
    connection.close()
    path.write_bytes(path.read_bytes()[:-4096])
    salvaged, found = salvage(path)
    recovered = {one.data for one in found}
    assert recovered <= {(0).to_bytes(4, "little") * 50, *contents}
    assert len(recovered) > 240
    assert salvaged.damage.remarks


def test_what_stands_behind_a_damaged_place_of_the_log_is_recovered(tmp_path, salvage):
    path = tmp_path / "bag.db3"
    connection = sqlite3.connect(path, isolation_level=None)
    connection.execute("PRAGMA journal_mode = WAL")
    connection.execute("PRAGMA wal_autocheckpoint = 0")
    connection.executescript(OLD_SCHEMA)
    for begin in range(0, 1000, 100):
        connection.execute("BEGIN")
        insert(connection, begin, begin + 100)
        connection.execute("COMMIT")
    crashed = copy_of_open(path, tmp_path / "crashed")
    connection.close()
    log = crashed.with_name("bag.db3-wal")
    data = bytearray(log.read_bytes())
    data[len(data) // 2] ^= 1
    log.write_bytes(data)
    salvaged, found = salvage(crashed)
    numbers = [one.received for one in found]
    assert numbers == sorted(set(numbers))
    assert 960 < len(numbers) < 1000
    assert {0, 999} <= set(numbers)
    assert "the log is damaged at byte" in salvaged.damage.remarks[0]


def test_a_journal_does_not_delete_the_file_that_it_names(tmp_path, salvage):
    path, victim = tmp_path / "bag.db3", tmp_path / "victim"
    write_old_bag(path, 300)
    connection = sqlite3.connect(path, isolation_level=None)
    connection.execute("PRAGMA cache_size = 5")
    connection.execute("BEGIN")
    connection.execute("UPDATE messages SET timestamp = timestamp + 1000")
    crashed = copy_of_open(path, tmp_path / "crashed")
    connection.close()
    victim.write_bytes(b"precious")
    name = str(victim).encode()
    journal = crashed.with_name("bag.db3-journal")
    ending = struct.pack(">I", len(name)) + struct.pack(">I", sum(name))
    journal.write_bytes(
        journal.read_bytes()
        + struct.pack(">I", 2**30 // 4096 + 1)
        + name
        + ending
        + bytes.fromhex("d9d505f920a163d7")
    )
    salvaged, found = salvage(crashed)
    assert victim.exists()
    assert len(found) == 300
    assert "the journal is left out" in salvaged.damage.remarks[0]


def test_flipped_bits_never_stop_the_salvage(small_bag, tmp_path, salvage):
    data = (small_bag(storage="sqlite3") / "bag_0.db3").read_bytes()
    bits = np.random.default_rng(5)
    damaged = tmp_path / "damaged.db3"
    full = 0
    for _ in range(300):
        flipped = bytearray(data)
        for _ in range(bits.choice((1, 1, 30))):
            flipped[bits.integers(len(data))] ^= 1 << bits.integers(8)
        damaged.write_bytes(flipped)
        _, found = salvage(damaged)
        full += len(found) >= 29
    assert full > 100


@pytest.mark.parametrize("content", [b"", b"SQLite format 3\0", bytes(5000), b"text " * 999])
def test_nonsense_has_no_messages(tmp_path, content, salvage):
    path = tmp_path / "nonsense.db3"
    path.write_bytes(content)
    salvaged, found = salvage(path)
    assert found == []
    assert salvaged.topics == []
