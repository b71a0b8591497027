"""A recovered bag is whole, stands beside the damaged one, and that one stays as it is."""

import numpy as np
import pytest
import yaml
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from bdt_bags.file_checksums import checksum_entry
from bdt_bags.reading.bag_reader import BagError
from bdt_bags.recovery import damaged_mcap_file as damaged_mcap_module
from bdt_bags.recovery import recover_bag as recover_module
from bdt_bags.recovery.recover_bag import recover_bag
from bdt_bags.writing.bag_files import BagFiles
from bdt_bags.writing.topic_metadata import SerializedMessage, topic_metadata
from bdt_bringup.cli import run_command

STORE = get_typestore(Stores.ROS2_JAZZY)
STORAGES = ["mcap", "sqlite3"]


def read(path):
    with Reader(path) as reader:
        return [(one.topic, received, data) for one, received, data in reader.messages()]


def expected(messages):
    return [(("/even", "/odd")[one.topic], one.received, one.data) for one in messages]


def information(path):
    text = (path / "metadata.yaml").read_text(encoding="utf-8")
    return yaml.safe_load(text)["rosbag2_bagfile_information"]


@pytest.mark.parametrize("storage", STORAGES)
@pytest.mark.parametrize("compression", ["none", "zstd"])
@pytest.mark.parametrize("metadata", [True, False])
def test_a_whole_bag_is_copied(small_bag, small_messages, storage, compression, metadata):
    bag = small_bag(storage=storage, compression=compression)
    if not metadata:
        (bag / "metadata.yaml").unlink()
    recovery = recover_bag(bag)
    assert recovery.output == bag.with_name("bag_recovered")
    assert read(recovery.output) == expected(small_messages)
    assert recovery.messages == {"/even": 15, "/odd": 15}
    assert (recovery.start, recovery.end) == (1000, 1029)
    custom = {"recovered_from": "bag", "bytes_not_understood": "0"}
    if metadata:
        custom["messages_dropped"] = "2"
    if (recovery.output / "bag_recovered_0.db3").exists():
        custom |= [checksum_entry(recovery.output / "bag_recovered_0.db3")]
    assert information(recovery.output)["custom_data"] == custom


def test_a_bare_file_is_enough_and_the_output_can_be_chosen(small_bag, small_messages, tmp_path):
    bag = small_bag()
    assert recover_bag(bag / "bag_0.mcap").output == bag / "bag_0_recovered"
    chosen = tmp_path / "new" / "place"
    assert read(recover_bag(bag / "bag_0.mcap", chosen).output) == expected(small_messages)


@pytest.mark.parametrize("storage", STORAGES)
def test_files_are_taken_in_the_order_of_their_numbers(small_bag, storage, tmp_path):
    bag = small_bag(storage=storage, split_duration=2e-9)
    assert len(information(bag)["files"]) == 15
    (bag / "metadata.yaml").unlink()
    recovery = recover_bag(bag)
    assert list(recovery.damage)[9].startswith("bag_9.")
    assert [received for _, received, _ in read(recovery.output)] == list(range(1000, 1030))
    starts = [
        one["starting_time"]["nanoseconds_since_epoch"]
        for one in information(recovery.output)["files"]
    ]
    assert starts == list(range(1000, 1030, 2))


@pytest.mark.parametrize(
    ("storage", "mode"),
    [
        (StoragePlugin.MCAP, CompressionMode.NONE),
        (StoragePlugin.MCAP, CompressionMode.STORAGE),
        (StoragePlugin.SQLITE3, CompressionMode.NONE),
        (StoragePlugin.SQLITE3, CompressionMode.MESSAGE),
        (StoragePlugin.SQLITE3, CompressionMode.FILE),
    ],
)
def test_bags_of_other_recorders_are_read(tmp_path, storage, mode):
    writer = Writer(tmp_path / "bag", version=9, storage_plugin=storage)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection("/text", "std_msgs/msg/String", typestore=STORE)
        for number in range(100):
            writer.write(connection, number, number.to_bytes(4, "little") * 9)
    recovery = recover_bag(tmp_path / "bag")
    assert read(recovery.output) == read(tmp_path / "bag")
    assert recovery.messages == {"/text": 100}


def test_an_unfinished_compression_does_not_hide_the_original(small_bag, small_messages):
    bag = small_bag(storage="sqlite3")
    (bag / "bag_0.db3.zstd").write_bytes(b"\x28\xb5\x2f\xfd torn")
    assert read(recover_bag(bag).output) == expected(small_messages)


def test_a_torn_compressed_file_is_read_as_far_as_it_goes(small_bag):
    packed = small_bag(storage="sqlite3", compression="zstd") / "bag_0.db3.zstd"
    packed.write_bytes(packed.read_bytes()[:-40])
    with pytest.raises(BagError, match="holds no message that could be recovered"):
        recover_bag(packed)


@pytest.mark.parametrize("storage", STORAGES)
def test_nothing_expands_further_than_a_file_of_its_size_may(tmp_path, monkeypatch, storage):
    for module in (recover_module, damaged_mcap_module):
        monkeypatch.setattr(module, "allowed_size", lambda size: 2 * size)
    bag = BagFiles(tmp_path / "bag", storage=storage, compression="zstd")
    bag.add_topic(topic_metadata("/zeros", "std_msgs/msg/String", ""))
    bag.append([SerializedMessage(0, 1, 1, bytes(1_000_000))])
    bag.close({})
    with pytest.raises(BagError, match="holds no message that could be recovered"):
        recover_bag(tmp_path / "bag")


@pytest.mark.parametrize("storage", STORAGES)
def test_damage_of_any_kind_ends_in_a_bag_or_in_one_line(small_bag, tmp_path, storage):
    bag = small_bag(storage=storage)
    bits = np.random.default_rng(7)
    originals = {file: file.read_bytes() for file in bag.iterdir()}
    recovered = 0
    for number in range(40):
        for file, data in originals.items():
            changed = bytearray(data)
            for _ in range(bits.choice((0, 1, 5))):
                changed[bits.integers(len(changed))] = bits.integers(256)
            file.write_bytes(changed[: bits.choice((len(data), bits.integers(len(data))))])
        output = tmp_path / f"output_{number}"
        refusal = refusal_to_recover(bag, output)
        assert "\n" not in refusal
        assert bool(refusal) != output.exists()
        if not refusal:
            assert len(read(output)) > 0
            recovered += 1
    assert recovered > 10


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (lambda path: path / "missing", "does not exist"),
        (lambda path: path, "holds no .mcap and no .db3 file"),
        (lambda path: file(path / "bag.txt", b"text"), "must be a bag folder, a .mcap or a .db3"),
        (lambda path: file(path / "bag.mcap", b""), "holds no message that could be recovered"),
        (lambda path: file(path / "bag.db3", b"text"), "holds no message that could be recovered"),
        (lambda path: folder(path / "x", "a.mcap", "b.db3"), "must be one bag"),
        (lambda path: folder(path / "x", "a.mcap", output=True), "exists already"),
    ],
)
def test_nonsense_is_refused_in_one_line(tmp_path, capsys, make, reason):
    assert run_command(["recover", str(make(tmp_path))]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ")
    assert reason in error
    assert error.count("\n") == 1
    assert not list(tmp_path.glob("bag_recovered"))


def refusal_to_recover(bag, output):
    try:
        recover_bag(bag, output)
    except BagError as error:
        return str(error)
    return ""


def file(path, data):
    path.write_bytes(data)
    return path


def folder(path, *names, output=False):
    path.mkdir()
    for name in names:
        (path / name).write_bytes(b"")
    if output:
        path.with_name("x_recovered").mkdir()
    return path


def test_the_command_tells_what_it_recovered_and_what_not(small_bag, capsys):
    path = small_bag() / "bag_0.mcap"
    data = path.read_bytes()
    path.write_bytes(data[: data.rindex(b"\x06", 0, len(data) - 2500) - 200])
    assert run_command(["recover", str(path.parent)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[1] for line in lines[:2]] == ["/even", "/odd"]
    assert lines[-2].endswith("bytes not understood")
    assert lines[-1] == f"bag: {path.parent}_recovered"
