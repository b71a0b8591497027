"""Checksums of what lies outside the chunks of an mcap file: index, topics, attachments, metadata.

A reader checks those of the chunks. What is outside tells it which chunks there are, and what is
in them: one bit there hides a topic. Format: https://mcap.dev/spec
"""

import zlib
from collections.abc import Sequence
from struct import Struct
from typing import IO, NamedTuple

from bdt_bags.bag_error import BagError

PIECE = 2**20

_FOOTER = Struct("<QQI")
_DATA_END = Struct("<I")
_RECORD_HEAD = 9
_SUMMED_OF_FOOTER = _RECORD_HEAD + 16


class Place(NamedTuple):
    """Where a record begins in the file, and its content [bytes]."""

    start: int
    content: bytes


def check_checksums(file: IO[bytes], data_ends: Sequence[Place], footer: Place) -> None:
    """Compare the checksums of the data and of the summary; a writer may leave out both.

    Parameters
    ----------
    file : binary file
        The file, open for reading.
    data_ends : sequence of Place
        Records that end the data; there must be one where there is a summary.
    footer : Place
        The record that ends the file.

    Raises
    ------
    BagError
        If a checksum is wrong, or a record is missing that may hold one.
    """
    if len(footer.content) != _FOOTER.size:
        raise BagError("has a damaged end")
    summary, _, summary_sum = _FOOTER.unpack(footer.content)
    if summary and len(data_ends) != 1:
        raise BagError(f"has {len(data_ends)} ends of its data: must have one")
    for end in data_ends:
        if len(end.content) != _DATA_END.size:
            raise BagError("has a damaged end of its data")
        (data_sum,) = _DATA_END.unpack(end.content)
        if data_sum and data_sum != _checksum(file, 0, end.start):
            raise BagError("is damaged: the checksum of its data is wrong")
    if summary_sum:
        begin = summary or footer.start
        if summary_sum != _checksum(file, begin, footer.start + _SUMMED_OF_FOOTER):
            raise BagError("is damaged: the checksum of its summary is wrong")


def _checksum(file: IO[bytes], begin: int, end: int) -> int:
    file.seek(begin)
    checksum = 0
    while begin < end and (piece := file.read(min(PIECE, end - begin))):
        checksum = zlib.crc32(piece, checksum)
        begin += len(piece)
    return checksum
