"""Bags that are written here are what rosbag2 of Jazzy and rosbags read."""

import shutil
import sqlite3
from pathlib import Path

import pytest
import yaml
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from bdt_bags.recovery.recover_bag import recover_bag
from bdt_bags.writing import bag_files
from bdt_bags.writing.bag_files import BagFiles
from bdt_bags.writing.topic_metadata import BagWriteError, SerializedMessage, topic_metadata

QOS = """\
- history: keep_last
  depth: 7
  reliability: best_effort
  durability: transient_local
  deadline: {sec: 9223372036, nsec: 854775807}
  lifespan: {sec: 9223372036, nsec: 854775807}
  liveliness: automatic
  liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}
  avoid_ros_namespace_conventions: false"""
START = 1_800_000_000_000_000_000
MILLISECOND = 1_000_000
KINDS = [(storage, how) for storage in ("mcap", "sqlite3") for how in ("none", "zstd")]


def message(number: int, topic: int = 0) -> SerializedMessage:
    time = START + number * MILLISECOND
    return SerializedMessage(topic, time, time, number.to_bytes(8, "little") * 8)


def opened(path: Path, **options) -> BagFiles:
    bag = BagFiles(path, **options)
    bag.add_topic(topic_metadata("/count", "std_msgs/msg/String", QOS))
    bag.add_topic(topic_metadata("/silent", "sensor_msgs/msg/JointState", ""))
    return bag


def information(path: Path):
    text = (path / "metadata.yaml").read_text(encoding="utf-8")
    return yaml.safe_load(text)["rosbag2_bagfile_information"]


def read(path: Path):
    with Reader(path) as reader:
        return [(one.topic, received, data) for one, received, data in reader.messages()]


@pytest.mark.parametrize(("storage", "compression"), KINDS)
@pytest.mark.parametrize("split", [{}, {"split_duration": 0.1}])
def test_rosbags_reads_the_messages_that_were_written(tmp_path, storage, compression, split):
    bag = opened(tmp_path / "bag", storage=storage, compression=compression, **split)
    for begin in range(0, 300, 70):
        bag.append([message(number) for number in range(begin, min(begin + 70, 300))])
        bag.commit()
    bag.close({"messages_dropped": "0"})
    assert read(tmp_path / "bag") == [
        ("/count", message(number).received, message(number).data) for number in range(300)
    ]


@pytest.mark.parametrize(("storage", "compression"), KINDS)
def test_the_metadata_are_those_of_version_9(tmp_path, storage, compression):
    bag = opened(tmp_path / "bag", storage=storage, compression=compression, split_duration=0.2)
    bag.append([message(number) for number in range(300)])
    bag.close({"messages_dropped": "3"})
    found = information(tmp_path / "bag")
    store = get_typestore(Stores.ROS2_JAZZY)
    assert found["version"] == 9
    assert found["storage_identifier"] == storage
    assert found["starting_time"] == {"nanoseconds_since_epoch": START}
    assert found["duration"] == {"nanoseconds": 299 * MILLISECOND}
    assert found["message_count"] == 300
    count, silent = found["topics_with_message_count"]
    assert (count["message_count"], silent["message_count"]) == (300, 0)
    assert count["topic_metadata"] == {
        "name": "/count",
        "type": "std_msgs/msg/String",
        "serialization_format": "cdr",
        "offered_qos_profiles": yaml.safe_load(QOS),
        "type_description_hash": store.hash_rihs01("std_msgs/msg/String"),
    }
    assert silent["topic_metadata"]["offered_qos_profiles"] == []
    suffix = {"mcap": "mcap", "sqlite3": "db3"}[storage]
    suffix += ".zstd" if (storage, compression) == ("sqlite3", "zstd") else ""
    assert found["relative_file_paths"] == [f"bag_0.{suffix}", f"bag_1.{suffix}"]
    assert found["compression_mode"] == ("FILE" if suffix.endswith("zstd") else "")
    assert [(one["path"], one["message_count"]) for one in found["files"]] == [
        (f"bag_0.{suffix}", 200),
        (f"bag_1.{suffix}", 100),
    ]
    assert found["files"][1]["starting_time"]["nanoseconds_since_epoch"] == message(200).received
    told = {key: value for key, value in found["custom_data"].items() if "crc32" not in key}
    assert told == {"messages_dropped": "3"}
    names = {file.name for file in (tmp_path / "bag").iterdir()}
    assert names == {"metadata.yaml", *found["relative_file_paths"]}


def test_an_mcap_has_schemas_hashes_checksums_and_a_message_index(tmp_path):
    bag = opened(tmp_path / "bag", compression="zstd")
    bag.append([message(number) for number in range(100)])
    bag.close()
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
        assert {one.compression for one in summary.chunk_indexes} == {"zstd"}
        assert all(one.message_index_offsets for one in summary.chunk_indexes)
        channel = summary.channels[1]
        assert channel.metadata["offered_qos_profiles"] == QOS
        assert channel.metadata["topic_type_hash"].startswith("RIHS01_")
        assert summary.schemas[channel.schema_id].encoding == "ros2msg"
        assert summary.schemas[channel.schema_id].data.startswith(b"string data")
        assert summary.statistics.message_count == 100


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_file_is_split_when_it_has_reached_the_size(tmp_path, storage):
    bag = opened(tmp_path / "bag", storage=storage, split_size=200_000)
    bag.append([message(number) for number in range(10_000)])
    bag.close()
    found = information(tmp_path / "bag")
    sizes = [(tmp_path / "bag" / one["path"]).stat().st_size for one in found["files"]]
    assert len(sizes) > 3
    assert all(200_000 <= size < 400_000 for size in sizes[:-1])
    assert read(tmp_path / "bag")[-1][2] == message(9999).data


@pytest.mark.parametrize(("storage", "compression"), KINDS)
def test_what_was_committed_can_be_read_without_the_end_of_the_file(tmp_path, storage, compression):
    bag = opened(tmp_path / "bag", storage=storage, compression=compression)
    bag.append([message(number) for number in range(100)])
    bag.commit()
    bag.sync()
    assert information(tmp_path / "bag")["custom_data"] == {"recording": "unfinished"}
    # rosbags wants the end of an mcap; Jazzy's own reader does not.
    recovered = recover_bag(tmp_path / "bag").output
    assert [data for _, _, data in read(recovered)] == [
        message(number).data for number in range(100)
    ]
    bag.close()
    assert "recording" not in (information(tmp_path / "bag")["custom_data"] or {})


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_topic_may_come_while_the_bag_is_written(tmp_path, storage):
    bag = opened(tmp_path / "bag", storage=storage)
    bag.append([message(0)])
    bag.commit()
    late = bag.add_topic(topic_metadata("/late", "std_msgs/msg/String", ""))
    bag.append([message(1, late)])
    bag.close()
    assert [topic for topic, _, _ in read(tmp_path / "bag")] == ["/count", "/late"]


def test_a_sqlite3_file_has_the_tables_of_schema_4(tmp_path):
    bag = opened(tmp_path / "bag", storage="sqlite3")
    bag.append([message(0)])
    bag.close()
    with sqlite3.connect(tmp_path / "bag" / "bag_0.db3") as connection:
        assert connection.execute("SELECT schema_version FROM schema").fetchall() == [(4,)]
        row = connection.execute("SELECT metadata_version, metadata FROM metadata").fetchone()
        definitions = connection.execute("SELECT topic_type, encoding FROM message_definitions")
        assert set(definitions) == {
            ("std_msgs/msg/String", "ros2msg"),
            ("sensor_msgs/msg/JointState", "ros2msg"),
        }
    assert row[0] == 9
    assert yaml.safe_load(row[1])["message_count"] == 1


def test_a_folder_that_exists_is_refused_and_a_type_that_nobody_knows_too(tmp_path):
    with pytest.raises(FileExistsError):
        BagFiles(tmp_path)
    with pytest.raises(ValueError, match="must be of a type of Jazzy's common interfaces"):
        topic_metadata("/x", "my_msgs/msg/Mine", "")


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"storage": "mcap"}, "mcap needs the Python package mcap"),
        ({"storage": "sqlite3", "compression": "zstd"}, "zstd needs the Python package zstandard"),
    ],
)
def test_a_package_that_is_missing_is_named_before_anything_is_written(
    tmp_path, monkeypatch, options, says
):
    monkeypatch.setattr(bag_files, "find_spec", lambda _: None)
    with pytest.raises(BagWriteError, match=says):
        BagFiles(tmp_path / "bag", **options)
    assert not (tmp_path / "bag").exists()


def test_a_closed_bag_takes_nothing_more(tmp_path):
    bag = opened(tmp_path / "bag")
    bag.close()
    with pytest.raises(BagWriteError, match="closed"):
        bag.split()


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_bag_that_is_deleted_while_it_is_synced_is_called_deleted(tmp_path, storage, monkeypatch):
    folder = tmp_path / "bag"
    files = BagFiles(folder, storage=storage)
    files.commit()
    monkeypatch.setattr(type(files._file), "sync", lambda _: shutil.rmtree(folder))
    with pytest.raises(BagWriteError, match=r"^bag_0\..* was deleted or moved$"):
        files.sync()
