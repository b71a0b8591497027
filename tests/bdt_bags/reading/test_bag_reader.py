"""Bags of all kinds, and one clear line for what is none."""

from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from bdt_bags.reading import bag_reader
from bdt_bags.reading.bag_reader import BagError, read_bag
from bdt_bags.reading.recording import load_recording
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    COMMAND,
    MEASUREMENT,
    REFERENCE,
    TELEMETRY,
    TRUTH,
    Topic,
)


@pytest.mark.parametrize("storage", list(StoragePlugin))
@pytest.mark.parametrize(
    "compression", [CompressionMode.NONE, CompressionMode.MESSAGE, CompressionMode.FILE]
)
def test_every_storage_gives_the_same(
    following_loop, following_bag, tmp_path, storage, compression
):
    path = following_loop.write(tmp_path / "bag", storage=storage, compression=compression)
    expected, found = load_recording(following_bag), load_recording(path)
    np.testing.assert_array_equal(found.telemetry, expected.telemetry)
    np.testing.assert_array_equal(found.truth, expected.truth)
    np.testing.assert_array_equal(found.dead_zones, expected.dead_zones)
    assert found.message_counts == expected.message_counts


@pytest.mark.parametrize("storage", list(StoragePlugin))
def test_bare_file(small_loop, tmp_path, storage):
    path = small_loop.write(tmp_path / "bag", storage=storage)
    (file,) = (x for x in path.iterdir() if x.suffix != ".yaml")
    assert load_recording(file).telemetry.shape == (1000, 3)


def test_bag_is_not_changed(small_loop, tmp_path):
    path = small_loop.write(tmp_path / "bag", storage=StoragePlugin.SQLITE3)
    before = {x.name: (x.read_bytes(), x.stat().st_mtime_ns) for x in path.iterdir()}
    load_recording(path)
    assert {x.name: (x.read_bytes(), x.stat().st_mtime_ns) for x in path.iterdir()} == before


def test_missing_path(tmp_path):
    with pytest.raises(BagError, match="does not exist"):
        read_bag(tmp_path / "nothing")


def test_empty_folder(tmp_path):
    with pytest.raises(BagError, match=r"has no metadata\.yaml: must be a rosbag2 folder"):
        read_bag(tmp_path)


def test_folder_without_metadata_names_the_file(small_loop, tmp_path):
    path = small_loop.write(tmp_path / "bag")
    (path / "metadata.yaml").unlink()
    with pytest.raises(BagError, match=r"bag\.mcap can be given by itself"):
        read_bag(path)


@pytest.mark.parametrize("name", ["bag.txt", "bag.mcap", "bag.db3"])
@pytest.mark.parametrize("content", [b"", b"not a bag" * 100])
def test_file_that_is_no_bag(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(BagError, match=name):
        read_bag(tmp_path / name)


def test_metadata_of_another_version(small_loop, tmp_path):
    path = small_loop.write(tmp_path / "bag")
    metadata = path / "metadata.yaml"
    metadata.write_text(metadata.read_text().replace("version: 9", "version: 99"))
    with pytest.raises(BagError, match="version 99"):
        read_bag(path)


def test_telemetry_or_measurement_is_required(small_loop, tmp_path):
    path = small_loop.without(TELEMETRY, MEASUREMENT, TRUTH, REFERENCE).write(tmp_path / "bag")
    with pytest.raises(BagError, match=r"lacks topic telemetry \(.*\) or measurement \("):
        read_bag(path)


def test_required_topic_of_the_wrong_type(small_loop, tmp_path):
    messages = small_loop.without(TELEMETRY)
    wrong = Topic(TELEMETRY.name, REFERENCE.message_type, "")
    messages.add(wrong, 0.0, small_loop.items[1][3])
    with pytest.raises(BagError, match=r"/telemetry has type .*: must be std_msgs"):
        read_bag(messages.write(tmp_path / "bag"))


def test_topic_of_two_loops(small_loop, tmp_path):
    messages = small_loop.without()
    other = next(item for item in small_loop.items if item[0] == "/telemetry")
    messages.items.append(("/other/telemetry", *other[1:]))
    with pytest.raises(
        BagError,
        match=r"holds 2 loops, in the namespaces / and /other: choose one with --namespace NAME",
    ):
        read_bag(messages.write(tmp_path / "bag"))


def test_extra_topics_of_other_types_and_namespaces(small_loop, tmp_path):
    messages = small_loop.without()
    _, type_, _, message = small_loop.items[1]
    for name in ("/arm/measurement", "/arm/reference", "/arm/joint_states"):
        messages.items.append((name, type_, 0.5, message))
    messages.items.append(("/arm/truth", "rosgraph_msgs/msg/Clock", 0.5, _clock(small_loop)))
    bag = read_bag(messages.write(tmp_path / "bag"))
    assert bag.topics[MEASUREMENT].name == "/measurement"
    assert bag.message_counts["/arm/measurement"] == 1
    assert bag.topics[TRUTH].name == "/truth"


def _clock(loop):
    return next(item[3] for item in loop.items if item[0] == "/clock")


def test_optional_topics_may_be_missing(small_loop, tmp_path):
    bare = small_loop.without(TRUTH, BACKLASH_ESTIMATE, MEASUREMENT, COMMAND)
    assert set(read_bag(bare.write(tmp_path / "bag")).topics) >= {TELEMETRY, REFERENCE}


def test_damaged_message(small_loop, tmp_path):
    messages = small_loop.without()
    messages.add(TRUTH, 1.0, b"\x00\x01\x00\x00\x01")
    with pytest.raises(BagError, match=r"message \d+ of /truth is damaged"):
        load_recording(messages.write(tmp_path / "bag"))


@pytest.mark.parametrize(
    ("compression", "reason"),
    [
        (CompressionMode.NONE, "holds more data than a bag of its size may"),
        (CompressionMode.MESSAGE, r"message \d of /telemetry: zstd data expands to more than"),
    ],
)
def test_messages_that_together_are_too_large(
    small_loop, tmp_path, monkeypatch, compression, reason
):
    """Each of them may be allowed by itself."""
    path = small_loop.write(tmp_path / "bag", compression=compression)
    monkeypatch.setattr(bag_reader, "allowed_size", lambda _: 20_000)
    with pytest.raises(BagError, match=reason):
        read_bag(path)


def test_errors_are_value_errors(tmp_path: Path):
    with pytest.raises(ValueError, match="bag"):
        load_recording(tmp_path)
