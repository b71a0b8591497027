"""A folder is created with those above it, and the name of each is carried to the disk.

What that is good for is tested in recovery/test_recovery_after_power_cut.py.
"""

import os
from pathlib import Path

import pytest

from bdt_msgs_py.folder_sync import create_folder


@pytest.fixture
def synced(monkeypatch):
    """Return a list of the folders that were synced."""
    folders = []
    real = os.fsync

    def sync(descriptor):
        real(descriptor)
        folders.append(Path(f"/proc/self/fd/{descriptor}").readlink())

    monkeypatch.setattr(os, "fsync", sync)
    return folders


def test_each_new_name_is_synced_from_above(tmp_path, synced):
    create_folder(tmp_path / "a" / "b" / "c")
    assert (tmp_path / "a" / "b" / "c").is_dir()
    assert synced == [tmp_path, tmp_path / "a", tmp_path / "a" / "b"]


def test_a_relative_folder_is_created_where_the_process_is(tmp_path, synced, monkeypatch):
    monkeypatch.chdir(tmp_path)
    create_folder(Path("a/b"))
    assert synced == [tmp_path, tmp_path / "a"]


def test_a_folder_that_exists_is_left_alone(tmp_path, synced):
    create_folder(tmp_path)
    assert synced == []


def test_a_file_in_the_way_is_an_error(tmp_path):
    (tmp_path / "a").touch()
    with pytest.raises(OSError, match="a"):
        create_folder(tmp_path / "a" / "b")
