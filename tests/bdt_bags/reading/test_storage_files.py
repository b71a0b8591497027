"""From a path to files that may be read; the bag stays as it is."""

import os
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from backports import zstd
from rosbags.rosbag2 import StoragePlugin

from bdt_bags.bag_error import BagError
from bdt_bags.reading.recording import load_recording
from bdt_bags.reading.storage_files import storage_files


def state(folder: Path) -> dict[str, tuple[bytes, int]]:
    """Return contents and times; that of the folder tells of files that came and went."""
    files = {x.name: (x.read_bytes(), x.stat().st_mtime_ns) for x in folder.iterdir()}
    return files | {".": (b"", folder.stat().st_mtime_ns)}


def refused(path: Path) -> str:
    with pytest.raises(BagError) as caught:
        load_recording(path)
    assert str(caught.value).startswith(f"bag {path}: ")
    return str(caught.value)


def test_bag_is_not_changed(stored_bags, tmp_path):
    for name, bag in stored_bags.items():
        path = bag.write(tmp_path / name)
        before = state(path)
        load_recording(path)
        assert state(path) == before, name


def test_bag_in_a_folder_that_cannot_be_written(stored_bags, tmp_path):
    path = stored_bags["sqlite3_none"].write(tmp_path / "bag")
    path.chmod(0o555)
    assert len(load_recording(path).telemetry) == 300
    path.chmod(0o755)


def test_file_of_a_compressed_bag_by_itself(stored_bags, tmp_path):
    for kind in ("mcap_file", "sqlite3_file", "mcap_message", "sqlite3_message"):
        path = stored_bags[kind].write(tmp_path / kind)
        assert len(load_recording(path / stored_bags[kind].storage).telemetry) == 300


def test_content_tells_what_a_file_is(stored_bags, tmp_path):
    data = stored_bags["sqlite3_none"].files["sqlite3_none.db3"]
    (tmp_path / "recording").write_bytes(data)
    assert len(load_recording(tmp_path / "recording").telemetry) == 300


@pytest.mark.parametrize("name", ["100%25.db3", "what?.db3", "a#b.db3", "ä ö.db3"])
def test_names_that_mean_something_in_an_uri(stored_bags, tmp_path, name):
    (tmp_path / name).write_bytes(stored_bags["sqlite3_none"].files["sqlite3_none.db3"])
    assert len(load_recording(tmp_path / name).telemetry) == 300
    assert [x.name for x in tmp_path.iterdir()] == [name]


def test_split_bag(stored_bags, small_loop, tmp_path):
    """The second file is one of another storage time: the same topics, later."""
    whole = load_recording(small_loop.write(tmp_path / "whole"))
    early, late = small_loop.without(), small_loop.without()
    early.items = [item for item in small_loop.items if item[2] <= 1.0]
    late.items = [item for item in small_loop.items if item[2] > 1.0]
    bag = early.write(tmp_path / "bag")
    shutil.copy(late.write(tmp_path / "late") / "late.mcap", bag)
    metadata = (bag / "metadata.yaml").read_text()
    (bag / "metadata.yaml").write_text(metadata.replace("- bag.mcap", "- bag.mcap\n  - late.mcap"))
    split = load_recording(bag)
    np.testing.assert_array_equal(split.telemetry, whole.telemetry)
    assert split.message_counts == whole.message_counts


def test_log_of_a_killed_recorder(stored_bags, tmp_path):
    """What sqlite has not yet moved from its log counts; log and database stay as they are."""
    path = tmp_path / "bag.db3"
    path.write_bytes(stored_bags["sqlite3_none"].files["sqlite3_none.db3"])
    killed = tmp_path / "killed"
    killed.mkdir()
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("DELETE FROM messages WHERE rowid % 2 AND topic_id != 2")
        connection.commit()
        for file in (path, path.with_name("bag.db3-wal")):
            shutil.copy(file, killed)
    before = state(killed)
    counts = load_recording(killed / "bag.db3").message_counts
    assert state(killed) == before
    assert counts == load_recording(path).message_counts
    (killed / "bag.db3-wal").unlink()
    assert sum(load_recording(killed / "bag.db3").message_counts.values()) > sum(counts.values())


def test_what_is_no_bag(tmp_path):
    for name, content, reason in [
        ("empty.mcap", b"", "is empty: must be an mcap or a sqlite3 file"),
        ("notes.txt", b"hello", "is neither an mcap nor a sqlite3 file: must be a rosbag2 folder"),
        ("old.bag", b"#ROSBAG V2.0\n", "is a ROS 1 bag: convert it with rosbags-convert"),
        ("x.mcap.zstd", zstd.compress(b""), "is empty"),
        ("y.mcap.zstd", zstd.compress(b"hello"), "is neither an mcap nor a sqlite3 file"),
    ]:
        (tmp_path / name).write_bytes(content)
        assert reason in refused(tmp_path / name)


def test_folders_without_metadata(stored_bags, tmp_path):
    assert "has no metadata.yaml: must be a rosbag2 folder" in refused(tmp_path)
    for name in ("a.mcap", "b.mcap"):
        (tmp_path / name).write_bytes(stored_bags["mcap_none"].files["mcap_none.mcap"])
    assert "it has 2 storage files, each can be given by itself" in refused(tmp_path)


def test_links_and_pipes_are_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.mcap")
    (tmp_path / "device.mcap").symlink_to("/dev/zero")
    (tmp_path / "circle.mcap").symlink_to("circle.mcap")
    (tmp_path / "nowhere.mcap").symlink_to("nothing")
    assert "must be a rosbag2 folder or an ordinary file" in refused(tmp_path / "pipe.mcap")
    assert "must be a rosbag2 folder or an ordinary file" in refused(tmp_path / "device.mcap")
    assert "cannot be read: Too many levels" in refused(tmp_path / "circle.mcap")
    assert "cannot be read: No such file" in refused(tmp_path / "nowhere.mcap")


@pytest.mark.parametrize("kind", ["mcap_none", "sqlite3_none", "mcap_file"])
def test_no_permission(stored_bags, tmp_path, monkeypatch, kind):
    """Tests may run as root, whom no permission stops."""
    path = stored_bags[kind].write(tmp_path / "bag")
    opened = Path.open

    def forbidden(file, *arguments, **options):
        if file.name == stored_bags[kind].storage:
            raise PermissionError(13, "Permission denied", str(file))
        return opened(file, *arguments, **options)

    monkeypatch.setattr(Path, "open", forbidden)
    assert refused(path).endswith("cannot be read: Permission denied")


def test_copies_are_removed(stored_bags, tmp_path):
    path = stored_bags["mcap_file"].write(tmp_path / "bag")
    with storage_files(path) as (file,):
        assert file.suffix == ".mcap"
        assert file.parent != path
    assert not file.parent.exists()


@pytest.mark.parametrize("storage", list(StoragePlugin))
def test_reason_names_the_file_of_a_folder(small_loop, tmp_path, storage):
    path = small_loop.write(tmp_path / "bag", storage=storage)
    (file,) = (x for x in path.iterdir() if x.suffix != ".yaml")
    file.write_bytes(b"")
    assert f"{file.name}: is empty" in refused(path)
