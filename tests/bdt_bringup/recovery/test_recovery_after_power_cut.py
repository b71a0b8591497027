"""A power cut at any step of the recorder loses nothing that was synced, and invents nothing."""

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import Reader

from bdt_bringup.bag_writing.bag_files import BagFiles
from bdt_bringup.bag_writing.recorded_topic import Message, recorded_topic
from bdt_bringup.bags.bag_error import BagError
from bdt_bringup.recovery.recover_bag import recover_bag

KINDS = {
    "mcap": {},
    "mcap, zstd": {"compression": "zstd"},
    "mcap, split": {"split_size": 60_000},
    "sqlite3": {"storage": "sqlite3"},
    "sqlite3, split, zstd": {"storage": "sqlite3", "split_size": 60_000, "compression": "zstd"},
}
CUTS = 30
COMMITS = 12
COMMIT_MESSAGES = 8
NAMES = ("/even", "/odd")


@pytest.fixture(scope="module")
def losing_disk():
    path = Path(__file__).with_name("losing_disk.py")
    spec = spec_from_file_location(path.stem, path)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def content(number: int) -> bytes:
    """Return the message with a number, up to 5 kB and thus over several sectors."""
    return np.random.default_rng(number).bytes(8 + number * 7919 % 5000)


def record(folder: Path, choice: np.random.Generator, promise, options) -> None:
    """Write a bag and tell after each sync how many messages it is to keep."""
    bag = BagFiles(folder, **options)
    bag.add_topic(recorded_topic(NAMES[0], "std_msgs/msg/String", ""))
    count = 0
    for commit in range(COMMITS):
        if commit == COMMITS // 2:
            bag.add_topic(recorded_topic(NAMES[1], "std_msgs/msg/Header", ""))
        for _ in range(COMMIT_MESSAGES):
            topic = count % len(bag.topics)
            bag.append([Message(topic, 1000 + count, 1000 + count, content(count))])
            count += 1
        bag.commit()
        # The disk may be slower than the commits come.
        if choice.random() < 0.6:
            bag.sync()
            promise(count)
    bag.close()
    promise(count)


def recovered(source: Path) -> list[int]:
    """Return the numbers of the messages in what was recovered, after comparing their content."""
    numbers = []
    with Reader(recover_bag(source).output) as reader:
        for _, received, data in reader.messages():
            numbers.append(received - 1000)
            assert data == content(numbers[-1])
    return numbers


@pytest.mark.parametrize("kind", KINDS)
def test_all_that_was_synced_before_the_power_cut_is_recovered_byte_for_byte(
    tmp_path, monkeypatch, losing_disk, kind
):
    choice = np.random.default_rng(sum(kind.encode()))
    promised, steps = 0, 0
    states = []

    def promise(count):
        nonlocal promised
        promised = count

    def cut():
        nonlocal steps
        steps += 1
        states.append((promised, disk.remains(choice)))

    bag = tmp_path / "recorder" / "bag"
    bag.parent.mkdir()
    disk = losing_disk.LosingDisk(bag.parent, cut)
    with losing_disk.watched(disk, monkeypatch):
        record(bag, choice, promise, KINDS[kind])
    assert promised == COMMITS * COMMIT_MESSAGES
    for number in [*choice.choice(steps - 1, CUTS - 1, replace=False), steps - 1]:
        promised, remains = states[number]
        found = []
        rest = tmp_path / f"cut{number}"
        for path, data in remains.items():
            copy = rest / path.relative_to(bag.parent)
            if data == losing_disk.FOLDER:
                copy.mkdir(exist_ok=True, parents=True)
            else:
                copy.parent.mkdir(exist_ok=True, parents=True)
                copy.write_bytes(data)
        try:
            found = recovered(rest / "bag")
        except BagError:
            assert not promised, remains.keys()
        assert set(found) >= set(range(promised))
        assert found == sorted(set(found))
