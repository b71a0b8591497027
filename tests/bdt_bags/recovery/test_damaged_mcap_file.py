"""An mcap file cut anywhere, or with a bit flipped anywhere, gives its true messages or none."""

import numpy as np
import pytest
from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

from bdt_bags.recovery.damaged_mcap_file import DamagedMcapFile
from bdt_bags.writing.bag_files import BagFiles
from bdt_bags.writing.topic_metadata import SerializedMessage, topic_metadata

COMPRESSIONS = ["none", "zstd"]


def salvage(path):
    salvaged = DamagedMcapFile(path)
    return salvaged, list(salvaged.messages())


def chunk_ends(path):
    """Return where each chunk ends, by the library ``mcap``."""
    with path.open("rb") as file:
        records = StreamReader(file, emit_chunks=True).records
        return [file.tell() for record in records if isinstance(record, Chunk)]


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_a_whole_file_gives_all_and_no_remarks(small_bag, small_messages, compression):
    salvaged, found = salvage(small_bag(compression=compression) / "bag_0.mcap")
    assert found == small_messages
    assert [topic.name for topic in salvaged.topics] == ["/even", "/odd"]
    assert salvaged.damage.byte_count == 0
    assert salvaged.damage.remarks == []
    assert salvaged.compression == compression


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_a_file_cut_at_any_byte_gives_every_whole_chunk(
    tmp_path, small_bag, small_messages, compression
):
    whole = small_bag(compression=compression) / "bag_0.mcap"
    data, ends = whole.read_bytes(), chunk_ends(whole)
    assert len(ends) == 5
    cut = tmp_path / "cut.mcap"
    near_ends = {end + offset for end in ends for offset in range(-12, 12)}
    for size in sorted({*range(0, len(data), 11), *near_ends}):
        cut.write_bytes(data[:size])
        _, found = salvage(cut)
        assert found == small_messages[: len(found)]
        assert len(found) >= 6 * sum(end <= size for end in ends), size


def test_the_whole_messages_of_a_torn_chunk_are_recovered(tmp_path, small_bag, small_messages):
    whole = small_bag() / "bag_0.mcap"
    cut = tmp_path / "cut.mcap"
    # Before the end of the third chunk stand a message of 71 bytes and its half.
    cut.write_bytes(whole.read_bytes()[: chunk_ends(whole)[2] - 100])
    salvaged, found = salvage(cut)
    assert found == small_messages[:16]
    assert salvaged.damage.byte_count == 42


@pytest.mark.parametrize("compression", COMPRESSIONS)
@pytest.mark.parametrize("torn", [0, 600])
def test_a_sector_that_never_reached_the_disk_never_makes_a_message(tmp_path, compression, torn):
    # Random content: messages that lie in part on a lost sector would show.
    random = np.random.default_rng(5)
    messages = [SerializedMessage(0, 1000 + n, 1000 + n, random.bytes(700)) for n in range(20)]
    bag = BagFiles(tmp_path / "bag", compression=compression)
    bag.add_topic(topic_metadata("/random", "std_msgs/msg/String", ""))
    for begin in range(0, 20, 10):
        bag.append(messages[begin : begin + 10])
        bag.commit()
    bag.close()
    whole = tmp_path / "bag" / "bag_0.mcap"
    second, end = chunk_ends(whole)
    data = whole.read_bytes()[: end - torn]
    lost = tmp_path / "lost.mcap"
    for begin in range(second - second % 512 + 512, len(data), 512):
        lost.write_bytes(data[:begin] + bytes(512) + data[begin + 512 :])
        _, found = salvage(lost)
        assert found[:10] == messages[:10]
        assert set(found) <= set(messages)


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_a_flipped_bit_never_makes_a_message_that_was_not_there(
    tmp_path, small_bag, small_messages, compression
):
    data = (small_bag(compression=compression) / "bag_0.mcap").read_bytes()
    bits = np.random.default_rng(3)
    worst = len(small_messages)
    for _ in range(400):
        place = bits.integers(len(data))
        flipped = bytearray(data)
        flipped[place] ^= 1 << bits.integers(8)
        damaged = tmp_path / "damaged.mcap"
        damaged.write_bytes(flipped)
        salvaged, found = salvage(damaged)
        sent = {(one.received, one.data) for one in small_messages}
        assert {(one.received, one.data) for one in found} <= sent, place
        assert len(found) == len(set(found)), place
        worst = min(worst, len(found))
        if salvaged.topics and place > chunk_end_of_definitions(data):
            assert len(found) >= len(small_messages) - 6, place
    assert worst < len(small_messages)


def chunk_end_of_definitions(data):
    """Return where the first chunk ends: it declares the topics."""
    return 8 + data.index(b"\x07", data.rindex(b"\x05", 0, 3000))


def test_garbage_between_two_chunks_is_passed_over(tmp_path, small_bag, small_messages):
    whole = small_bag() / "bag_0.mcap"
    data, place = whole.read_bytes(), chunk_ends(whole)[1]
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(data[:place] + bytes(1000) + data[place:])
    salvaged, found = salvage(damaged)
    assert found == small_messages
    assert salvaged.damage.byte_count == 1000
    assert salvaged.damage.remarks == [f"byte {place}: no record, 1000 bytes"]


def test_a_chunk_with_a_wrong_checksum_is_left_out_and_told(tmp_path, small_bag, small_messages):
    whole = small_bag() / "bag_0.mcap"
    data = bytearray(whole.read_bytes())
    data[chunk_ends(whole)[2] - 20] ^= 1
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(data)
    salvaged, found = salvage(damaged)
    assert found == small_messages[:12] + small_messages[18:]
    (remark,) = salvaged.damage.remarks
    assert "chunk left out: its checksum is wrong" in remark


@pytest.mark.parametrize("cut", [0, 150])
@pytest.mark.parametrize(
    "options",
    [
        {"use_chunking": False},
        {"compression": CompressionType.LZ4},
        {"compression": CompressionType.NONE, "chunk_size": 500, "enable_crcs": False},
    ],
)
def test_files_of_other_recorders_are_read(tmp_path, options, cut):
    path = tmp_path / "other.mcap"
    with path.open("wb") as file:
        writer = Writer(file, **options)
        writer.start("ros2")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data")
        channel = writer.register_channel("/text", "cdr", schema, {})
        for number in range(50):
            writer.add_message(channel, number, number.to_bytes(4, "little") * 9, number, number)
        writer.flush()
        end = file.tell() if cut else None
        writer.finish()
    if cut:
        # Message indexes are cut off first where there are chunks.
        path.write_bytes(path.read_bytes()[: end - cut])
    salvaged, found = salvage(path)
    assert [one.received for one in found] == list(range(len(found)))
    assert all(one.data == one.received.to_bytes(4, "little") * 9 for one in found)
    assert len(found) >= (45 if cut else 50)
    assert salvaged.topics[0].message_type == "std_msgs/msg/String"


@pytest.mark.parametrize("content", [b"", b"\x89MCAP", bytes(5000), b"\x06" * 5000, b"text " * 99])
def test_nonsense_has_no_messages(tmp_path, content):
    path = tmp_path / "nonsense.mcap"
    path.write_bytes(content)
    salvaged, found = salvage(path)
    assert found == []
    assert salvaged.topics == []


def test_a_chunk_that_claims_to_be_huge_is_not_believed(tmp_path, small_bag):
    whole = small_bag(compression="zstd") / "bag_0.mcap"
    data, begin = bytearray(whole.read_bytes()), chunk_ends(whole)[0]
    place = data.index(b"zstd", begin) - 4 - 4 - 8
    data[place : place + 8] = (2**62).to_bytes(8, "little")
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(data)
    salvaged, found = salvage(damaged)
    assert len(found) == 24
    assert "its beginning is damaged" in salvaged.damage.remarks[0]
