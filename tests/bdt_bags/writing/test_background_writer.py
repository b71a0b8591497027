"""Whoever records never waits for the disk, loses little in a crash and is told what is lost."""

import errno
import os
import resource
import threading
import time

import pytest
from rosbags.rosbag2 import Reader

from bdt_bags.recovery.recover_bag import recover_bag
from bdt_bags.writing import mcap_file
from bdt_bags.writing.background_writer import COMMIT_PERIOD, BackgroundWriter
from bdt_bags.writing.bag_files import BagFiles
from bdt_bags.writing.topic_metadata import BagWriteError, topic_metadata

DEADLINE = 60.0
LIMIT = 300_000
STORAGES = ["mcap", "sqlite3"]


def wait_until(condition):
    end = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < end, f"not within {DEADLINE} s"
        time.sleep(0.01)


def write_until_trouble(writer, topic) -> int:
    """Write in small steps until the disk refuses; return the number of messages."""
    count = 0
    while not writer.disk_error:
        for _ in range(120):
            writer.write(topic, count, data(count))
            count += 1
        wait_until(lambda count=count: writer.disk_error or writer.message_count == count)
    return count


def data(number: int) -> bytes:
    return number.to_bytes(8, "little") * 125


def numbers(path) -> list[int]:
    with Reader(path) as reader:
        return [int.from_bytes(content[:8], "little") for _, _, content in reader.messages()]


@pytest.fixture
def begin(tmp_path):
    started = []

    def start(**options):
        limit = options.pop("queue_limit", 1 << 20)
        reports: list[str] = []
        writer = BackgroundWriter(BagFiles(tmp_path / "bag", **options), reports.append, limit)
        topic = writer.add_topic(topic_metadata("/count", "std_msgs/msg/String", ""))
        started.append(writer)
        return writer, topic, reports

    yield start
    for writer in started:
        if writer._thread.is_alive():
            writer.close({})


@pytest.fixture
def full_disk():
    """Return functions that make files grow no more, and grow again."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)

    def set_limit(size: int) -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))

    yield lambda: set_limit(LIMIT), lambda: set_limit(before[0])
    set_limit(before[0])


def test_messages_are_handed_to_the_system_without_a_close(begin, tmp_path):
    writer, topic, _ = begin()
    for number in range(10):
        writer.write(topic, number, data(number))
    wait_until(lambda: writer.message_count == 10)
    assert numbers(recover_bag(tmp_path / "bag").output) == list(range(10))


def test_what_was_committed_is_carried_to_the_disk_itself(begin, tmp_path, monkeypatch):
    synced = []
    real = os.fdatasync

    def noted(descriptor):
        size = os.fstat(descriptor).st_size
        real(descriptor)
        synced.append(size)

    monkeypatch.setattr(mcap_file.os, "fdatasync", noted)
    writer, topic, _ = begin()
    file = tmp_path / "bag" / "bag_0.mcap"
    for number in range(3):
        writer.write(topic, number, data(number))
        wait_until(lambda number=number: writer.message_count == number + 1)
        wait_until(lambda: synced and synced[-1] == file.stat().st_size)


def test_a_sync_that_failed_is_told_and_tried_again(begin, monkeypatch):
    refusing = threading.Event()
    synced = threading.Event()
    real = os.fdatasync

    def sync(descriptor):
        if refusing.is_set():
            raise OSError(errno.EIO, "Input/output error")
        real(descriptor)
        synced.set()

    refusing.set()
    monkeypatch.setattr(mcap_file.os, "fdatasync", sync)
    writer, _, reports = begin()
    wait_until(lambda: writer.disk_error == "Input/output error")
    refusing.clear()
    wait_until(synced.is_set)
    wait_until(lambda: not writer.disk_error)
    assert len(reports) == 2
    refusing.set()
    wait_until(lambda: writer.disk_error)
    refusing.clear()
    wait_until(lambda: not writer.disk_error)


def test_trouble_lasts_as_long_as_syncs_fail(begin, monkeypatch):
    failures = []

    def sync(_):
        failures.append(time.monotonic())
        raise OSError(errno.EIO, "Input/output error")

    with monkeypatch.context() as patches:
        patches.setattr(mcap_file.os, "fdatasync", sync)
        _, _, reports = begin()
        wait_until(lambda: len(failures) > 4)
    assert len(reports) == 1


def test_a_last_sync_that_failed_is_told(begin, monkeypatch):
    entered, released = threading.Event(), threading.Event()

    def sync(_):
        entered.set()
        assert released.wait(DEADLINE)
        raise OSError(errno.EIO, "Input/output error")

    writer, _, reports = begin()
    with monkeypatch.context() as patches:
        patches.setattr(mcap_file.os, "fdatasync", sync)
        wait_until(entered.is_set)
        ending = threading.Thread(target=writer.close, args=[{}])
        ending.start()
        wait_until(lambda: not writer._thread.is_alive())
        patches.undo()
        released.set()
        ending.join(DEADLINE)
    assert len(reports) == 1


def test_writing_does_not_wait_while_the_disk_does(begin, monkeypatch):
    blocked, released = threading.Event(), threading.Event()
    real = os.pwrite

    def slow(*arguments):
        blocked.set()
        assert released.wait(DEADLINE)
        return real(*arguments)

    writer, topic, reports = begin(queue_limit=100_000)
    monkeypatch.setattr(mcap_file.os, "pwrite", slow)
    writer.write(topic, 0, data(0))
    assert blocked.wait(DEADLINE)
    began = time.monotonic()
    for number in range(1, 201):
        writer.write(topic, number, data(number))
    assert time.monotonic() - began < DEADLINE / 2
    # A queue of 100 000 bytes holds 100 messages of 1000; the rest is dropped, and counted.
    assert writer.dropped == {topic: 100}
    released.set()
    wait_until(lambda: writer.message_count == 101)
    assert reports == []


@pytest.mark.parametrize("split", [{}, {"split_size": 5000}])
def test_the_system_gets_messages_while_a_sync_stands_still(begin, tmp_path, monkeypatch, split):
    """For a kill, what the system has is enough; files that are full are ended later."""
    entered, released = threading.Event(), threading.Event()
    real = os.fsync

    def slow(descriptor):
        if threading.current_thread() is not threading.main_thread():
            entered.set()
            assert released.wait(DEADLINE)
        real(descriptor)

    writer, topic, reports = begin(**split)
    for name in ("fdatasync", "fsync"):
        monkeypatch.setattr(os, name, slow)
    writer.write(topic, 0, data(0))
    assert entered.wait(DEADLINE)
    for number in range(1, 30):
        writer.write(topic, number, data(number))
        if number % 10 == 9:
            wait_until(lambda number=number: writer.message_count == number + 1)
    assert numbers(recover_bag(tmp_path / "bag", tmp_path / "killed").output) == list(range(30))
    released.set()
    writer.close({})
    assert numbers(tmp_path / "bag") == list(range(30))
    assert len(list((tmp_path / "bag").glob("*.mcap"))) >= (3 if split else 1)
    assert reports == []


def test_how_long_messages_wait_for_the_system_is_measured(begin, tmp_path, monkeypatch):
    entered, released = threading.Event(), threading.Event()
    real = os.pwrite

    def slow(*arguments):
        entered.set()
        assert released.wait(DEADLINE)
        return real(*arguments)

    writer, topic, _ = begin()
    writer.write(topic, 0, data(0))
    wait_until(lambda: writer.longest_wait > 0)
    with monkeypatch.context() as patches:
        patches.setattr(mcap_file.os, "pwrite", slow)
        taken = time.monotonic()
        writer.write(topic, 1, data(1))
        assert entered.wait(DEADLINE)
        wait_until(lambda: time.monotonic() > taken + 2 * COMMIT_PERIOD)
        released.set()
        wait_until(lambda: writer.message_count == 2)
        passed = time.monotonic() - taken
        wait_until(lambda: writer.longest_wait > 2 * COMMIT_PERIOD)
    assert writer.longest_wait <= passed + 0.1
    writer.close({})
    text = (tmp_path / "bag" / "metadata.yaml").read_text(encoding="utf-8")
    assert f"longest_wait_s: '{writer.longest_wait:.3f}'" in text


@pytest.mark.parametrize("storage", STORAGES)
def test_recording_goes_on_when_a_full_disk_has_space_again(begin, tmp_path, full_disk, storage):
    fill, free = full_disk
    writer, topic, reports = begin(storage=storage)
    fill()
    count = write_until_trouble(writer, topic)
    for _ in range(3000):
        writer.write(topic, count, data(count))
        count += 1
    assert writer.dropped[topic] > 0
    assert len(reports) == 1
    assert f"cannot write {tmp_path / 'bag'}" in reports[0]
    free()
    wait_until(lambda: not writer.disk_error)
    assert "can be written again" in reports[1]
    writer.write(topic, count, data(count))
    writer.close({})
    found = numbers(tmp_path / "bag")
    assert found == sorted(set(found))
    assert found[-1] == count
    assert len(found) == count + 1 - writer.dropped[topic]
    assert len(reports) == 2


@pytest.mark.parametrize("storage", STORAGES)
def test_what_a_full_disk_has_taken_is_kept(begin, tmp_path, full_disk, storage):
    fill, free = full_disk
    writer, topic, _ = begin(storage=storage)
    fill()
    count = write_until_trouble(writer, topic)
    with pytest.raises(BagWriteError):
        writer.close({})
    free()
    written = writer.message_count
    assert writer.dropped[topic] == count - written
    assert written > 100
    assert numbers(recover_bag(tmp_path / "bag").output)[:written] == list(range(written))


def test_an_unexpected_failure_reaches_the_one_who_records(begin, monkeypatch):
    writer, topic, _ = begin()
    monkeypatch.setattr(BagFiles, "commit", lambda self: 1 / 0)

    def write():
        writer.write(topic, 0, data(0))

    with pytest.raises(ZeroDivisionError):
        wait_until(write)
    with pytest.raises(ZeroDivisionError):
        writer.close({})
