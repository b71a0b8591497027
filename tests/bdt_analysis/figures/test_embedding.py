"""What a page carries along comes out as it went in."""

import base64
import gzip

import numpy as np

from bdt_analysis.figures.embedding import packed_arrays, packed_text


def unpacked(data: bytes, sizes: list[int]) -> list[np.ndarray]:
    """Undo the shuffling as the page does it."""
    arrays, offset = [], 0
    for size in sizes:
        planes = np.frombuffer(data, np.uint8, 4 * size, offset).reshape(4, size)
        arrays.append(np.frombuffer(np.ascontiguousarray(planes.T).tobytes(), "<f4"))
        offset += 4 * size
    assert offset == len(data)
    return arrays


def test_arrays_come_back_as_float32():
    arrays = [np.array([0.0, 1.5, -2e-7, np.nan]), np.empty(0), np.linspace(0, 120, 1001)]
    found = unpacked(packed_arrays(arrays), [4, 0, 1001])
    for array, back in zip(arrays, found, strict=True):
        np.testing.assert_array_equal(back, array.astype(np.float32))


def test_a_position_that_ran_away_becomes_infinite_without_a_warning():
    (found,) = unpacked(packed_arrays([np.array([1e99])]), [1])
    assert np.isinf(found).all()


def test_shuffling_halves_the_room_of_a_smooth_signal():
    time = np.linspace(0.0, 120.0, 20_000)
    signal = np.exp(-time / 9) * np.sin(7 * time)
    plain = len(gzip.compress(signal.astype("<f4").tobytes(), 9))
    assert len(gzip.compress(packed_arrays([signal]), 9)) < 0.9 * plain
    plain = len(gzip.compress(time.astype("<f4").tobytes(), 9))
    assert len(gzip.compress(packed_arrays([time]), 9)) < 0.5 * plain


def test_text_is_gzip_and_the_same_every_time():
    text = packed_text(b"some bytes" * 100)
    assert gzip.decompress(base64.b64decode(text)) == b"some bytes" * 100
    assert text == packed_text(b"some bytes" * 100)
