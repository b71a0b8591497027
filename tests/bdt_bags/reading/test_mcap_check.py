"""Lengths that an mcap file declares."""

import struct

import pytest
from rosbags.rosbag2 import CompressionMode

from bdt_bags.bag_error import BagError
from bdt_bags.reading.bounded_decompression import ALWAYS_ALLOWED
from bdt_bags.reading.mcap_check import LARGEST_CHANNELS, check_mcap


@pytest.fixture
def check(tmp_path):
    def run(content: bytes) -> None:
        (tmp_path / "x.mcap").write_bytes(content)
        check_mcap(tmp_path / "x.mcap")

    return run


@pytest.mark.parametrize("kind", ["mcap_none", "mcap_message", "mcap_storage", "mcap_lz4"])
def test_intact(stored_bags, check, kind):
    bag = stored_bags[kind]
    check(bag.files[bag.storage])


def test_cut_anywhere(stored_bags, check):
    data = stored_bags["mcap_none"].files["mcap_none.mcap"]
    for length in range(0, len(data), 997):
        with pytest.raises(BagError):
            check(data[:length])


@pytest.mark.parametrize("length", [2**32, 2**62, 2**64 - 1])
def test_record_longer_than_the_file(mcap, check, length):
    with pytest.raises(BagError, match=f"record at byte 8 declares {length} bytes: only 100 are"):
        check(mcap.file(struct.pack("<BQ", 5, length) + bytes(71)))


def test_no_end(mcap, check):
    with pytest.raises(BagError, match="has no end"):
        check(mcap.magic + mcap.record(1, b"") + mcap.magic)


@pytest.mark.parametrize("compression", ["", "lz4", "zstd"])
@pytest.mark.parametrize("declared", [0, 999, 1001])
def test_chunk_of_another_size(mcap, check, compression, declared):
    chunk = mcap.chunk(bytes(1000), compression, declared=declared)
    with pytest.raises(BagError, match=r"declares \d+ bytes: holds 1000|expands to more than"):
        check(mcap.file(chunk))


def test_chunks_that_together_are_too_large(mcap, check):
    content = mcap.record(0, bytes(2**20))
    half = mcap.chunk(content, "zstd", declared=ALWAYS_ALLOWED // 2 + 1)
    whole = mcap.chunk(content, "zstd")
    check(mcap.file(whole, whole))
    with pytest.raises(BagError, match="more than a file of this size may hold"):
        check(mcap.file(mcap.chunk(b"x", "zstd", declared=ALWAYS_ALLOWED + 1)))
    with pytest.raises(BagError, match="declares"):
        check(mcap.file(half, half))


def test_unknown_compression(mcap, check):
    body = struct.pack("<QQQII", 0, 0, 0, 0, 4) + b"gzip" + bytes(8)
    with pytest.raises(BagError, match="has compression 'gzip': must be none, lz4 or zstd"):
        check(mcap.file(mcap.record(6, body)))


@pytest.mark.parametrize("field", range(16, 34, 8))
def test_index_that_disagrees(stored_bags, check, mcap, field):
    data = bytearray(stored_bags["mcap_none"].files["mcap_none.mcap"])
    place = next(place for place, opcode, _ in mcap.records(bytes(data)) if opcode == 8)
    data[place + 9 + field] ^= 1
    with pytest.raises(BagError, match=f"chunk index at byte {place} does not agree"):
        check(bytes(data))


def test_chunk_that_is_indexed_twice(mcap, check):
    """Otherwise a short file could repeat one chunk for ever."""
    chunk = mcap.chunk(mcap.record(0, bytes(991)), "")
    place = len(mcap.magic)
    sizes = struct.pack("<QQ", 1000, 1000)
    entry = struct.pack("<QQQQIQI", 0, 0, place, len(chunk), 0, 0, 0) + sizes
    check(mcap.file(chunk, mcap.record(8, entry)))
    with pytest.raises(BagError, match="does not agree"):
        check(mcap.file(chunk, mcap.record(8, entry), mcap.record(8, entry)))


@pytest.mark.parametrize("within", ["file", "chunk"])
def test_long_descriptions_of_channels(mcap, check, within):
    channel = mcap.record(4, bytes(LARGEST_CHANNELS + 1))
    with pytest.raises(BagError, match=rf"describes channels in {LARGEST_CHANNELS + 1} bytes"):
        check(mcap.file(channel if within == "file" else mcap.chunk(channel, "zstd")))


def test_every_compression_of_the_writer_is_checked():
    assert {mode.name for mode in CompressionMode} == {"NONE", "FILE", "MESSAGE", "STORAGE"}
