"""Frames: their bytes, and how they are found again in whatever a line delivers."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_serial_drive.frames import (
    LONGEST_FRAME,
    LONGEST_PAYLOAD,
    START,
    Frame,
    FrameReader,
    checksum,
    encoded,
)

FRAMES = st.builds(
    Frame, st.integers(0, 255), st.integers(0, 255), st.binary(max_size=LONGEST_PAYLOAD)
)
QUIET = bytes(LONGEST_FRAME)
"""What ends every frame that may have begun before it, and begins none."""


def crc_bit_by_bit(content):
    """Return the CRC-16 as its definition has it: division of polynomials, bit by bit."""
    remainder = 0xFFFF
    for byte in content:
        remainder ^= byte << 8
        for _ in range(8):
            remainder = (remainder << 1) ^ (0x1021 if remainder & 0x8000 else 0)
            remainder &= 0xFFFF
    return remainder


def pieces(content, cuts):
    """Return bytes as a line delivers them: in parts that end anywhere."""
    ends = sorted({min(cut, len(content)) for cut in cuts} | {0, len(content)})
    return [content[begin:end] for begin, end in pairwise(ends)]


def test_the_bytes_of_a_frame_are_those_of_the_reference():
    # A voltage of 12 V, 12 000 000 units of 1 uV, in the frame with number 7.
    assert encoded(Frame(0x02, 7, bytes.fromhex("001bb700"))).hex() == "b562040207001bb70094e8"


def test_the_checksum_has_the_check_value_of_its_name():
    assert checksum(b"123456789") == 0x29B1


@given(st.binary(max_size=300))
def test_the_checksum_is_that_of_its_definition(content):
    assert checksum(content) == crc_bit_by_bit(content)


def test_a_payload_that_does_not_fit_is_refused():
    with pytest.raises(ValueError, match="payload of 256 bytes: must be at most 255"):
        encoded(Frame(1, 0, bytes(256)))


@given(st.lists(FRAMES, max_size=8), st.lists(st.integers(0, 2000), max_size=8))
def test_frames_come_out_as_they_went_in_however_the_bytes_are_cut(frames, cuts):
    reader = FrameReader()
    line = b"".join(map(encoded, frames))
    found = [frame for piece in pieces(line, cuts) for frame in reader.feed(piece)]
    assert found == frames
    assert reader.skipped == 0


@given(st.lists(st.binary(max_size=400), max_size=8))
def test_no_bytes_make_it_fail_and_all_are_accounted_for(received):
    reader = FrameReader()
    found = [frame for piece in [*received, QUIET] for frame in reader.feed(piece)]
    in_frames = sum(len(encoded(frame)) for frame in found)
    assert reader.skipped + in_frames == sum(map(len, received)) + len(QUIET)


GARBAGE = st.one_of(
    st.binary(max_size=60),
    # The beginning of a frame whose end is missing, which lets one expect bytes.
    st.tuples(FRAMES, st.integers(1, LONGEST_FRAME)).map(lambda t: encoded(t[0])[: t[1]][:-1]),
    # What the first bytes of the next frame happen to complete is a frame, and no garbage.
).filter(lambda garbage: not FrameReader().feed(garbage + START))


@given(
    st.lists(st.tuples(GARBAGE, FRAMES), min_size=1, max_size=5),
    st.lists(st.integers(0, 3000), max_size=5),
)
def test_every_intact_frame_is_found_behind_any_garbage(parts, cuts):
    reader = FrameReader()
    line = b"".join(garbage + encoded(frame) for garbage, frame in parts) + QUIET
    found = iter([frame for piece in pieces(line, cuts) for frame in reader.feed(piece)])
    assert all(frame in found for _, frame in parts)


@given(FRAMES, st.integers(0, 10_000))
def test_a_flipped_bit_is_never_a_frame(frame, flipped):
    bits = bytearray(encoded(frame))
    bit = flipped % (8 * len(bits))
    bits[bit // 8] ^= 1 << bit % 8
    assert frame not in FrameReader().feed(bytes(bits) + QUIET)


@given(FRAMES)
def test_a_doubled_frame_is_found_twice_with_one_number(frame):
    assert FrameReader().feed(encoded(frame) * 2) == [frame, frame]


def test_the_start_may_come_in_two_parts():
    reader = FrameReader()
    frame = Frame(3, 0, b"")
    assert reader.feed(b"\x00" + START[:1]) == []
    assert reader.feed(encoded(frame)[1:]) == [frame]
    assert reader.skipped == 1
