"""Compressed data in bounded memory."""

import struct

import lz4.frame
import pytest
from backports import zstd

from bdt_bags.bag_error import BagError
from bdt_bags.reading.bounded_decompression import (
    ALWAYS_ALLOWED,
    LARGEST_COMPRESSION_RATIO,
    LARGEST_DECOMPRESSED_SIZE,
    allowed_size,
    decompress,
    decompress_file,
    decompress_message,
    decompressed_size,
)

DATA = bytes(range(256)) * 20_000
COMPRESS = {"zstd": zstd.compress, "lz4": lz4.frame.compress}


@pytest.mark.parametrize("compression", COMPRESS)
def test_content_and_size(compression):
    compressed = COMPRESS[compression](DATA)
    assert decompress(compressed, compression, len(DATA)) == DATA
    assert decompressed_size(compressed, compression, len(DATA)) == len(DATA)
    two_frames = compressed + COMPRESS[compression](b"more")
    assert decompressed_size(two_frames, compression, len(DATA) + 4) == len(DATA) + 4


@pytest.mark.parametrize("compression", COMPRESS)
def test_more_than_allowed(compression):
    compressed = COMPRESS[compression](DATA)
    with pytest.raises(BagError, match=f"expands to more than {len(DATA) - 1} bytes"):
        decompress(compressed, compression, len(DATA) - 1)


@pytest.mark.parametrize("compression", COMPRESS)
@pytest.mark.parametrize("damage", [slice(0, -3), slice(1, None), slice(0, 5)])
def test_damaged(compression, damage):
    with pytest.raises(BagError, match=f"{compression} data is damaged"):
        decompress(COMPRESS[compression](DATA)[damage], compression, 2 * len(DATA))


def test_message():
    compressed = zstd.compress(DATA)
    assert decompress_message(compressed, len(DATA)) == DATA
    with pytest.raises(BagError, match="expands to more than 1000 bytes"):
        decompress_message(compressed, 1000)
    for bad in (compressed[:-1], compressed + b"x", compressed[:4] + compressed[5:]):
        with pytest.raises(BagError, match="zstd data is damaged"):
            decompress_message(bad, len(DATA))


def test_declared_size_is_not_believed():
    """Frames whose headers declare a terabyte, with nothing in them."""
    zstd_frame = b"\x28\xb5\x2f\xfd\xc0\x58" + struct.pack("<Q", 2**40) + b"\x01\x00\x00"
    assert decompress(zstd_frame, "zstd", 100) == decompress_message(zstd_frame, 100) == b""
    context = lz4.frame.create_compression_context()
    lz4_frame = lz4.frame.compress_begin(context, source_size=2**40) + bytes(4)
    with pytest.raises(BagError, match="lz4 data is damaged"):
        decompressed_size(lz4_frame, "lz4", 100)


def test_file(tmp_path):
    (tmp_path / "small").write_bytes(zstd.compress(DATA))
    decompress_file(tmp_path / "small", tmp_path / "out")
    assert (tmp_path / "out").read_bytes() == DATA


def test_allowed_size():
    """A small file may become 256 MB, a large one 200 times as large, none more than 16 GB."""
    assert allowed_size(0) == allowed_size(1000) == ALWAYS_ALLOWED == 2**28
    assert allowed_size(10**7) == LARGEST_COMPRESSION_RATIO * 10**7
    assert allowed_size(10**12) == LARGEST_DECOMPRESSED_SIZE == 2**34
