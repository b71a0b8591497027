"""A power cut at any step of the recorder loses nothing that was synced, and invents nothing."""

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import Reader

from bdt_bags.bag_error import BagError
from bdt_bags.bag_format import METADATA_FILE
from bdt_bags.recovery.recover_bag import recover_bag
from bdt_bags.writing import sqlite_file
from bdt_bags.writing.bag_files import BagFiles
from bdt_bags.writing.topic_metadata import SerializedMessage, topic_metadata

KINDS = {
    "mcap": {},
    "mcap, zstd": {"compression": "zstd"},
    "mcap, split": {"split_size": 50_000},
    "sqlite3": {"storage": "sqlite3"},
    "sqlite3, split, zstd": {"storage": "sqlite3", "split_size": 50_000, "compression": "zstd"},
}
CUTS = 8
LAST_CUTS = 4
COMMITS = 10
COMMIT_MESSAGES = 5
NAMES = ("/even", "/odd")
PLACE = "new/folder/bag"


@pytest.fixture(scope="module")
def faulty_disk():
    path = Path(__file__).with_name("faulty_disk.py")
    spec = spec_from_file_location(path.stem, path)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def content(number: int) -> bytes:
    """Return the message with a number, up to 5 kB and thus over several sectors."""
    return np.random.default_rng(number).bytes(8 + number * 7919 % 5000)


def record(folder: Path, choice: np.random.Generator, promise, end, options) -> None:
    """Write a bag and tell after each sync how many messages it is to keep."""
    bag = BagFiles(folder, **options)
    bag.add_topic(topic_metadata(NAMES[0], "std_msgs/msg/String", ""))
    count = 0
    for commit in range(COMMITS):
        if commit == COMMITS // 2:
            bag.add_topic(topic_metadata(NAMES[1], "std_msgs/msg/Header", ""))
        for _ in range(COMMIT_MESSAGES):
            topic = count % len(bag.topics)
            bag.append([SerializedMessage(topic, 1000 + count, 1000 + count, content(count))])
            count += 1
        bag.commit()
        # The disk may be slower than the commits come; the last is left to the end of the bag.
        if choice.random() < 0.6 and commit < COMMITS - 1:
            bag.sync()
            promise(count)
    end(bag)
    promise(count)


def numbers(bag: Path) -> list[int]:
    """Return the numbers of the messages in a bag, after comparing their content."""
    found = []
    with Reader(bag) as reader:
        for _, received, data in reader.messages():
            found.append(received - 1000)
            assert data == content(found[-1])
    return found


def claims_to_be_whole(remains: dict[Path, bytes]) -> bool:
    """Tell whether there are metadata that do not say that the bag is unfinished."""
    texts = [data for path, data in remains.items() if path.name == METADATA_FILE]
    return any(b"recording: unfinished" not in text for text in texts)


def copy(remains: dict[Path, bytes], root: Path, target: Path) -> Path:
    """Write what is left below a folder, and return where the bag is or should be."""
    for path, data in remains.items():
        place = target / path.relative_to(root)
        place.parent.mkdir(exist_ok=True, parents=True)
        place.write_bytes(data)
    return target / PLACE


@pytest.mark.parametrize("end", [BagFiles.close, BagFiles.abandon])
@pytest.mark.parametrize("kind", KINDS)
def test_all_that_was_synced_before_the_power_cut_is_recovered_byte_for_byte(
    tmp_path, monkeypatch, faulty_disk, kind, end
):
    choice = np.random.default_rng(sum(kind.encode()))
    promised = 0
    states = []

    def promise(count):
        nonlocal promised
        promised = count

    # Several times in so short a bag.
    monkeypatch.setattr(sqlite_file, "_LONGEST_LOG", 30_000)
    root = tmp_path / "recorder"
    root.mkdir()
    disk = faulty_disk.FaultyDisk(root, lambda: states.append((promised, disk.remains(choice))))
    with faulty_disk.watched(disk, monkeypatch):
        record(root / PLACE, choice, promise, end, KINDS[kind])
        for _ in range(LAST_CUTS):
            disk.look()
    assert promised == COMMITS * COMMIT_MESSAGES
    last = range(len(states) - LAST_CUTS, len(states))
    for number in [*choice.choice(last.start, CUTS, replace=False), *last]:
        promised, remains = states[number]
        bag = copy(remains, root, tmp_path / f"cut{number}")
        found = []
        try:
            with faulty_disk.without_syncs(monkeypatch):
                found = numbers(recover_bag(bag).output)
        except BagError:
            assert not promised, sorted(remains)
        assert set(found) >= set(range(promised))
        assert found == sorted(set(found))
    # Whatever survives of the end, a bag that claims to be whole must be.
    whole = {number for number, (_, remains) in enumerate(states) if claims_to_be_whole(remains)}
    assert whole >= set(last if end is BagFiles.close else ())
    for number in whole:
        remains = states[number][1]
        bag = copy(remains, root, tmp_path / f"whole{number}")
        assert numbers(bag) == list(range(COMMITS * COMMIT_MESSAGES))
