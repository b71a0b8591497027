"""Rows of a sqlite3 file taken from its pages one by one, whatever the tree above them says.

A tree of pages that is damaged leads a reader astray: rows come again and again, or none comes
behind a damaged one. The pages at its leaves hold all rows and know nothing of the tree. Each page
is looked at once, so work and output are bounded by the file.

References
----------
Database file format, https://www.sqlite.org/fileformat2.html, sections 1.3 and 1.6 to 2.1.
"""

import mmap
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from bdt_bags.bag_format import SQLITE_MAGIC, SQLITE_PAGE_SIZES

Value = int | float | str | bytes | None

_USUAL_PAGE_SIZE = 4096
_TABLE_LEAF = 0x0D
_FILE_HEADER = 100
_PAGE_HEADER = 8
_INTEGER_SIZES = (0, 1, 2, 3, 4, 6, 8)
_MOST_COLUMNS = 64


class Row(NamedTuple):
    """A row of whatever table.

    Attributes
    ----------
    identifier : int
        Number of the row in its table.
    values : tuple
        One value for each column; that of the column that stands for the identifier is None.
    """

    identifier: int
    values: tuple[Value, ...]


class Page(NamedTuple):
    """A leaf of a table.

    Attributes
    ----------
    place : int
        Where it begins in the file [byte].
    rows : list of Row
        Rows that are whole, in the order of the page.
    torn : int
        Number of rows that are not.
    """

    place: int
    rows: list[Row]
    torn: int


class SqlitePages:
    """The leaves of all tables of a file.

    Parameters
    ----------
    path : Path
        The file; it is only read. What its journal or log holds must be in it.

    Raises
    ------
    OSError
        If the file cannot be read.
    """

    def __init__(self, path: Path) -> None:
        with path.open("rb") as file:
            # An empty file cannot be mapped.
            self._data: mmap.mmap | bytes = (
                mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) if path.stat().st_size else b""
            )
        self.page_size, self._usable = self._sizes()
        self._used = bytearray(len(self._data) // self.page_size + 2)

    def leaves(self) -> Iterator[Page]:
        """Iterate over the leaves in the order of the file."""
        self.begin_anew()
        for place in range(0, len(self._data), self.page_size):
            content = self._data[place : place + self.page_size]
            header = _FILE_HEADER if place == 0 else 0
            if len(content) >= header + _PAGE_HEADER and content[header] == _TABLE_LEAF:
                yield self._leaf(place, content, header)

    def begin_anew(self) -> None:
        """Forget which pages belong to rows that were read, to read them once more."""
        self._used = bytearray(len(self._used))

    def leaf(self, place: int) -> Page:
        """Return the leaf that begins at a place [byte]."""
        content = self._data[place : place + self.page_size]
        return self._leaf(place, content, _FILE_HEADER if place == 0 else 0)

    def _sizes(self) -> tuple[int, int]:
        """Return the size of a page and what of it holds content [byte]."""
        page_size, reserved = _USUAL_PAGE_SIZE, 0
        if self._data[: len(SQLITE_MAGIC)] == SQLITE_MAGIC and len(self._data) >= _FILE_HEADER:
            stored = int.from_bytes(self._data[16:18], "big")
            page_size = {1: 65536}.get(stored, stored)
            reserved = self._data[20]
            if page_size not in SQLITE_PAGE_SIZES or page_size - reserved < 480:
                page_size, reserved = _USUAL_PAGE_SIZE, 0
        return page_size, page_size - reserved

    def _leaf(self, place: int, content: bytes, header: int) -> Page:
        count = int.from_bytes(content[header + 3 : header + 5], "big")
        begin = header + _PAGE_HEADER
        rows: list[Row] = []
        torn = 0
        room = len(content)
        for number in range(min(count, (len(content) - begin) // 2)):
            pointer = begin + 2 * number
            cell = int.from_bytes(content[pointer : pointer + 2], "big")
            try:
                row, size = self._row(content, cell)
            except (ValueError, IndexError):
                torn += 1
                continue
            # Rows that lie upon each other hold more than their page can.
            room -= size
            if room < 0:
                torn += 1
                break
            rows.append(row)
        return Page(place, rows, torn)

    def _row(self, content: bytes, cell: int) -> tuple[Row, int]:
        """Return a row and how much of its page it takes [byte]."""
        if not _PAGE_HEADER <= cell < len(content):
            raise ValueError("a row lies outside its page")
        size, position = _number(content, cell)
        identifier, position = _number(content, position)
        local = self._local_size(size)
        if size > len(self._data) or position + local > len(content):
            raise ValueError("a row is torn")
        payload = content[position : position + local]
        end = position + local
        if local < size:
            payload += self._overflow(int.from_bytes(content[end : end + 4], "big"), size - local)
            end += 4
        return Row(_signed(identifier), _values(payload)), end - cell

    def _local_size(self, size: int) -> int:
        """Return how many bytes of a row stand in its own page."""
        largest = self._usable - 35
        if size <= largest:
            return size
        least = (self._usable - 12) * 32 // 255 - 23
        wanted = least + (size - least) % (self._usable - 4)
        return wanted if wanted <= largest else least

    def _overflow(self, number: int, size: int) -> bytes:
        """Return what a chain of pages holds; no page belongs to two rows."""
        pieces = []
        while size > 0:
            place = (number - 1) * self.page_size
            if not 0 < number < len(self._used) or self._used[number]:
                raise ValueError("a row goes on where it cannot")
            piece = self._data[place + 4 : place + min(self._usable, size + 4)]
            if len(piece) < min(self._usable - 4, size):
                raise ValueError("a row is torn")
            self._used[number] = 1
            pieces.append(piece)
            size -= len(piece)
            number = int.from_bytes(self._data[place : place + 4], "big")
        return b"".join(pieces)

    def unknown_pages(self) -> int:
        """Return the number of whole pages that are neither of a tree nor the rest of a row.

        To be asked when all rows have been read.
        """
        kinds = (0x02, 0x05, 0x0A, _TABLE_LEAF)
        places = range(self.page_size, len(self._data), self.page_size)
        return sum(
            self._data[place] not in kinds and not self._used[place // self.page_size + 1]
            for place in places
        )

    def missing_pages(self) -> int:
        """Return how many pages the file had, as it says itself, and has no more."""
        there = len(self._data) // self.page_size
        return max(int.from_bytes(self._data[28:32], "big") - there, 0)


def _number(content: bytes, position: int) -> tuple[int, int]:
    """Return a number of variable length, and where it ends."""
    value = 0
    for place in range(position, position + 8):
        byte = content[place]
        value = value << 7 | byte & 0x7F
        if byte < 0x80:
            return value, place + 1
    return value << 8 | content[position + 8], position + 9


def _signed(number: int) -> int:
    return number - 2**64 if number >= 2**63 else number


def _values(payload: bytes) -> tuple[Value, ...]:
    header, position = _number(payload, 0)
    if header > len(payload):
        raise ValueError("a row ends in its header")
    kinds = []
    while position < header:
        kind, position = _number(payload, position)
        kinds.append(kind)
    if position != header or len(kinds) > _MOST_COLUMNS:
        raise ValueError("a row has a damaged header")
    values = []
    for kind in kinds:
        size = _size(kind)
        content = payload[position : position + size]
        if len(content) < size:
            raise ValueError("a row is shorter than it says")
        values.append(_value(kind, content))
        position += size
    if position != len(payload):
        raise ValueError("a row is longer than it says")
    return tuple(values)


def _size(kind: int) -> int:
    if kind < len(_INTEGER_SIZES):
        return _INTEGER_SIZES[kind]
    if kind in {10, 11}:
        raise ValueError("a row holds a value of a kind that is not used")
    return {7: 8, 8: 0, 9: 0}.get(kind, (kind - 12) // 2)


def _value(kind: int, content: bytes) -> Value:
    if kind == 0:
        return None
    if kind < len(_INTEGER_SIZES):
        return int.from_bytes(content, "big", signed=True)
    if kind in {8, 9}:
        return kind - 8
    if kind == 7:
        return float(struct.unpack(">d", content)[0])
    return content if kind % 2 == 0 else content.decode(errors="replace")
