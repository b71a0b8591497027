"""The list of files in metadata.yaml."""

import pytest
import yaml

from bdt_bags.bag_error import BagError
from bdt_bags.reading.metadata_file import LARGEST_METADATA, recorded_files

GOOD = {
    "version": 9,
    "storage_identifier": "mcap",
    "relative_file_paths": ["bag_1.mcap", "bag_0.mcap"],
    "compression_format": "",
}


@pytest.fixture
def read(tmp_path):
    for name in ("bag_0.mcap", "bag_1.mcap"):
        (tmp_path / name).touch()

    def run(text: str | None = None, **fields):
        content = text or yaml.safe_dump({"rosbag2_bagfile_information": {**GOOD, **fields}})
        (tmp_path / "metadata.yaml").write_text(content)
        return [file.path.name for file in recorded_files(tmp_path)]

    return run


@pytest.mark.parametrize("version", range(1, 10))
def test_order_of_the_bag(read, version):
    assert read(version=version) == ["bag_1.mcap", "bag_0.mcap"]


def test_paths_of_old_versions_and_other_places_lie_in_the_folder(read):
    assert read(relative_file_paths=["my_bag/bag_0.mcap"]) == ["bag_0.mcap"]
    with pytest.raises(BagError, match="lacks the file 'passwd'"):
        read(relative_file_paths=["../../../etc/passwd"])


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"version": 99}, "has rosbag2 version 99: must be 1 to 9"),
        ({"version": "9"}, "has rosbag2 version '9'"),
        ({"version": None}, "has rosbag2 version None"),
        ({"storage_identifier": "rocksdb"}, "has storage 'rocksdb': must be one of mcap, sqlite3"),
        ({"storage_identifier": ["mcap"]}, "has storage"),
        ({"compression_format": "lz4"}, "has compression format 'lz4': must be zstd"),
        ({"relative_file_paths": []}, "without relative_file_paths"),
        ({"relative_file_paths": "bag_0.mcap"}, "without relative_file_paths"),
        ({"relative_file_paths": [7]}, "without relative_file_paths"),
        ({"relative_file_paths": ["bag_0.mcap"] * 2}, "name a file twice"),
        ({"relative_file_paths": ["bag_2.mcap"]}, "lacks the file 'bag_2.mcap'"),
    ],
)
def test_fields(read, fields, reason):
    with pytest.raises(BagError, match=reason):
        read(**fields)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("{", "has a damaged metadata.yaml"),
        ("a: 2001-99-99", "has a damaged metadata.yaml"),
        ("- 1", "without rosbag2_bagfile_information"),
        ("rosbag2_bagfile_information: 1", "without rosbag2_bagfile_information"),
        ("a: &a [x, x]\nb: [*a, *a]", "with the alias 'a': must have none"),
        ("[" * 100_000, "nested deeper than 30"),
        ("a: " + "x" * LARGEST_METADATA, rf"metadata.yaml of {LARGEST_METADATA + 3} bytes"),
        ("a: !!python/object/apply:os.getcwd []", "has a damaged metadata.yaml"),
    ],
)
def test_texts_that_are_none(read, text, reason):
    with pytest.raises(BagError, match=reason):
        read(text)


def test_not_utf_8(read, tmp_path):
    read()
    (tmp_path / "metadata.yaml").write_bytes(b"\xff\xfe")
    with pytest.raises(BagError, match=r"has a damaged metadata\.yaml: 'utf-8'"):
        recorded_files(tmp_path)
