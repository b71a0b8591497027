"""Declared sizes of an mcap file, checked before anything is read by them.

A reader allocates what a record, a chunk or a compressed frame declares. So every length must lie
within the file, every chunk must decompress to what it declares and to no more than
:func:`~bdt_bags.reading.bounded_decompression.allowed_size`, and the index, which the reader
follows, must say of each chunk what the chunk says of itself. Format: https://mcap.dev/spec
"""

from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from struct import Struct
from typing import IO, NamedTuple

from bdt_bags.bag_error import BagError
from bdt_bags.bag_format import MCAP_MAGIC
from bdt_bags.reading.bounded_decompression import allowed_size, decompress, decompressed_size
from bdt_bags.reading.mcap_checksums import Place, check_checksums

LARGEST_CHANNELS = 2**20
"""Size of all descriptions of channels [bytes]: YAML, of which 0.2 MB are read in a second."""

FOOTER, SCHEMA, CHANNEL, CHUNK, CHUNK_INDEX, DATA_END = 0x02, 0x03, 0x04, 0x06, 0x08, 0x0F
DESCRIPTIONS = {FOOTER, SCHEMA, CHANNEL, CHUNK, CHUNK_INDEX, DATA_END}

_RECORD = Struct("<BQ")
_CHUNK_HEAD = Struct("<QQQII")
_INDEX_HEAD = Struct("<QQQQI")
_SIZE = Struct("<Q")
_TWO_SIZES = Struct("<QQ")
_LENGTH = Struct("<I")
_COMPRESSIONS = ("", "lz4", "zstd")


class Record(NamedTuple):
    """Where a record lies.

    Attributes
    ----------
    opcode : int
        Kind of record.
    start : int
        Place of its opcode in the file [bytes].
    begin, length : int
        Place and length of its content [bytes].
    """

    opcode: int
    start: int
    begin: int
    length: int


class Chunk(NamedTuple):
    """What a chunk declares: length of its record, compression and sizes [bytes]."""

    length: int
    compression: str
    compressed_size: int
    decompressed_size: int


def check_mcap(path: Path) -> None:
    """Check every length that an mcap file declares, and the checksums outside its chunks.

    Parameters
    ----------
    path : Path
        The file; it is read, at most one chunk of it at a time is in memory.

    Raises
    ------
    BagError
        If a length is not possible, a chunk decompresses too far, a checksum is wrong or the end is
        missing.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        if file.read(len(MCAP_MAGIC)) != MCAP_MAGIC:
            raise BagError("is not an mcap file")
        records = _descriptions(file, len(MCAP_MAGIC), size - len(MCAP_MAGIC))
        if not records or records[-1].opcode != FOOTER:
            raise BagError("has no end: it was cut off, or its recorder was killed")
        chunks = _checked_chunks(file, records, allowed_size(size))
        _check_index(file, records, chunks)
        _check_channels(records)
        ends = [Place(x.start, _content(file, x)) for x in records if x.opcode == DATA_END]
        check_checksums(file, ends, Place(records[-1].start, _content(file, records[-1])))
        (summary,) = _SIZE.unpack(_content(file, records[-1])[:8].ljust(8, b"\0"))
        if not any(x.opcode == SCHEMA and x.start >= summary > 0 for x in records):
            # Without a summary the reader looks for channels in the chunks.
            for record in records:
                if record.opcode == CHUNK:
                    content = _decompressed_chunk(file, record)
                    _check_channels(_descriptions(BytesIO(content), 0, len(content)))


def _records(file: IO[bytes], begin: int, end: int) -> Iterator[Record]:
    """Yield the records between two places, up to the footer."""
    while begin < end:
        file.seek(begin)
        head = file.read(_RECORD.size)
        if len(head) < _RECORD.size or begin + _RECORD.size > end:
            raise BagError(f"is cut off in the record at byte {begin}")
        opcode, length = _RECORD.unpack(head)
        if length > end - begin - _RECORD.size:
            raise BagError(
                f"record at byte {begin} declares {length} bytes: only "
                f"{end - begin - _RECORD.size} are left; the file is cut off or damaged"
            )
        yield Record(opcode, begin, begin + _RECORD.size, length)
        if opcode == FOOTER:
            return
        begin += _RECORD.size + length


def _descriptions(file: IO[bytes], begin: int, end: int) -> list[Record]:
    """Return the records that describe others; a file may hold millions of messages."""
    return [x for x in _records(file, begin, end) if x.opcode in DESCRIPTIONS]


def _checked_chunks(file: IO[bytes], records: list[Record], limit: int) -> dict[int, Chunk]:
    """Return what the chunks declare, by their place."""
    chunks: dict[int, Chunk] = {}
    for record in records:
        if record.opcode != CHUNK:
            continue
        chunk, begin = _chunk(file, record)
        chunks[record.start] = chunk
        limit -= chunk.decompressed_size
        if limit < 0:
            raise BagError(
                f"chunk at byte {record.start} declares {chunk.decompressed_size} bytes: "
                "more than a file of this size may hold"
            )
        if chunk.compression:
            file.seek(begin)
            data = file.read(chunk.compressed_size)
            size = decompressed_size(data, chunk.compression, chunk.decompressed_size)
        else:
            size = chunk.compressed_size
        if size != chunk.decompressed_size:
            raise BagError(
                f"chunk at byte {record.start} declares {chunk.decompressed_size} bytes: "
                f"holds {size}"
            )
    return chunks


def _chunk(file: IO[bytes], record: Record) -> tuple[Chunk, int]:
    """Return what a chunk declares, and where its data begins."""
    file.seek(record.begin)
    head = file.read(min(record.length, 64))
    damaged = BagError(f"chunk at byte {record.start} is damaged")
    if len(head) < _CHUNK_HEAD.size:
        raise damaged
    *_, decompressed, _, name_length = _CHUNK_HEAD.unpack_from(head)
    name = head[_CHUNK_HEAD.size : _CHUNK_HEAD.size + name_length]
    compression = name.decode("ascii", "replace")
    if name_length != len(name) or compression not in _COMPRESSIONS:
        raise BagError(
            f"chunk at byte {record.start} has compression {compression[:20]!r}: must be none, "
            "lz4 or zstd"
        )
    place = _CHUNK_HEAD.size + name_length
    if len(head) < place + _SIZE.size:
        raise damaged
    (compressed,) = _SIZE.unpack_from(head, place)
    begin = place + _SIZE.size
    if compressed != record.length - begin:
        raise damaged
    return Chunk(record.length, compression, compressed, decompressed), record.begin + begin


def _check_index(file: IO[bytes], records: list[Record], chunks: dict[int, Chunk]) -> None:
    """Each entry must describe a chunk of its own."""
    indexed = set()
    for record in records:
        if record.opcode != CHUNK_INDEX:
            continue
        place, entry = _index_entry(_content(file, record))
        if entry is None or chunks.get(place) != entry or place in indexed:
            raise BagError(f"chunk index at byte {record.start} does not agree with the chunks")
        indexed.add(place)


def _index_entry(content: bytes) -> tuple[int, Chunk | None]:
    """Return the place of a chunk and what the index says of it; None for a damaged entry."""
    if len(content) < _INDEX_HEAD.size:
        return 0, None
    _, _, place, length, offsets = _INDEX_HEAD.unpack_from(content)
    begin = _INDEX_HEAD.size + offsets + _SIZE.size
    if len(content) < begin + _LENGTH.size:
        return 0, None
    (name_length,) = _LENGTH.unpack_from(content, begin)
    begin += _LENGTH.size
    if len(content) != begin + name_length + _TWO_SIZES.size:
        return 0, None
    compression = content[begin : begin + name_length].decode("ascii", "replace")
    compressed, decompressed = _TWO_SIZES.unpack_from(content, begin + name_length)
    return place, Chunk(length - _RECORD.size, compression, compressed, decompressed)


def _check_channels(records: list[Record]) -> None:
    size = sum(record.length for record in records if record.opcode == CHANNEL)
    if size > LARGEST_CHANNELS:
        raise BagError(f"describes channels in {size} bytes: must be {LARGEST_CHANNELS} or less")


def _decompressed_chunk(file: IO[bytes], record: Record) -> bytes:
    chunk, begin = _chunk(file, record)
    file.seek(begin)
    data = file.read(chunk.compressed_size)
    return (
        decompress(data, chunk.compression, chunk.decompressed_size) if chunk.compression else data
    )


def _content(file: IO[bytes], record: Record) -> bytes:
    file.seek(record.begin)
    return file.read(record.length)
