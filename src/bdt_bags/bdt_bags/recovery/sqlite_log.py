"""Carries into a sqlite3 file what its write-ahead log holds, also behind a damaged place.

sqlite stops at the first frame of the log whose checksum is wrong. But each checksum goes on from
the one before, which is stored, so that the frames behind can be checked as well.

References
----------
Database file format, https://www.sqlite.org/fileformat2.html, section 4.
"""

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from struct import Struct
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_bags.bag_format import SQLITE_PAGE_SIZES
from bdt_bags.recovery.damaged_file import Damage

_HEADER = Struct(">8I")
_FRAME = Struct(">6I")
_SUMMED_OF_HEADER = 24
_SUMMED_OF_FRAME = 8


class _Frame(NamedTuple):
    """A frame whose checksum is right: number of its page, end of a transaction, where it is."""

    page: int
    commits: bool
    begin: int


def apply_log(file: Path, log: Path, damage: Damage) -> None:
    """Write the pages of all whole transactions of a log into its file.

    Parameters
    ----------
    file : Path
        A sqlite3 file; it is changed.
    log : Path
        Its write-ahead log; it is only read.
    damage : Damage
        Takes what could not be understood.

    Raises
    ------
    OSError
        If a file cannot be read or written.
    """
    data = log.read_bytes()
    if len(data) < _HEADER.size:
        if data:
            damage.note("the log ends in its header", len(data))
        return
    magic, _, page_size, _, *_ = _HEADER.unpack_from(data)
    if magic & ~1 != 0x377F0682 or page_size not in SQLITE_PAGE_SIZES:
        damage.note("the log has a damaged header: it is left out", len(data))
        return
    highest = (file.stat().st_size + len(data)) // page_size
    frames = list(_good_frames(data, page_size, "<u4" if magic == 0x377F0682 else ">u4", damage))
    while frames and not frames[-1].commits:
        frames.pop()
    with file.open("r+b") as target:
        for frame in frames:
            if 0 < frame.page <= highest:
                target.seek((frame.page - 1) * page_size)
                target.write(data[frame.begin : frame.begin + page_size])


def _good_frames(data: bytes, page_size: int, order: str, damage: Damage) -> Iterator[_Frame]:
    *_, first_salt, second_salt, first_sum, second_sum = _HEADER.unpack_from(data)
    salts, sums = (first_salt, second_salt), (first_sum, second_sum)
    if _checksum(data[:_SUMMED_OF_HEADER], (0, 0), order) != sums:
        damage.note("the log has a damaged header", _HEADER.size)
    strange: list[int] = []
    size = _FRAME.size + page_size
    for place in range(_HEADER.size, len(data) - size + 1, size):
        page, pages_then, *rest = _FRAME.unpack_from(data, place)
        content = place + _FRAME.size
        summed = _checksum(
            data[place : place + _SUMMED_OF_FRAME] + data[content : place + size], sums, order
        )
        sums = rest[2], rest[3]
        if tuple(rest[:2]) != salts:
            # At the end these are what is left of an older log.
            strange.append(place)
            continue
        for wrong in strange if summed == sums else [*strange, place]:
            damage.note(f"the log is damaged at byte {wrong}", size)
        strange.clear()
        if summed == sums:
            yield _Frame(page, pages_then > 0, content)


def _checksum(data: bytes, before: tuple[int, int], order: str) -> tuple[int, int]:
    """Return the checksum that goes on from another one.

    Each word is added to the sum of the last two sums, so that the weights are Fibonacci numbers.
    """
    words = np.frombuffer(data, dtype=order).astype(np.uint32)
    weights = _fibonacci_numbers(words.size + 2)
    both = np.concatenate([np.array(before, dtype=np.uint32), words])
    # F(N) s0 + F(N + 1) s1 + sum of F(N - i + 1) w_i
    last = np.concatenate([weights[words.size - 1 : words.size + 1], weights[words.size - 1 :: -1]])
    one = words.size - 1
    earlier = np.concatenate([weights[one - 1 : one + 1], weights[one - 1 :: -1], [np.uint32(0)]])
    return int(np.dot(both, earlier)), int(np.dot(both, last))


@cache
def _fibonacci_numbers(count: int) -> NDArray[np.uint32]:
    """Return F(1), F(2), ... modulo 2^32."""
    numbers = [1, 1]
    while len(numbers) < count:
        numbers.append((numbers[-1] + numbers[-2]) % 2**32)
    return np.array(numbers, dtype=np.uint32)
