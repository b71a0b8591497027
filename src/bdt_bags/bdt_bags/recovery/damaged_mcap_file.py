"""Reads an mcap file without its index and end, and past what is damaged in it.

References
----------
MCAP format specification, https://mcap.dev/spec: a record is an opcode (1 byte), the length of its
content (8 bytes) and the content; a chunk holds records, with a checksum.
"""

import mmap
import re
import struct
import zlib
from collections.abc import Generator, Iterator
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Schema

from bdt_bags.bag_format import MCAP_MAGIC
from bdt_bags.reading.bounded_decompression import allowed_size
from bdt_bags.recovery.damaged_file import Damage
from bdt_bags.recovery.decompression import (
    LARGEST_CHUNK,
    decompressed_lz4,
    decompressed_zstd,
)
from bdt_bags.recovery.lost_sectors import first_lost_sector
from bdt_bags.writing.topic_metadata import SerializedMessage, TopicMetadata

_HEADER = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")
_CHUNK = struct.Struct("<QQQI")
_OPCODES = range(Opcode.HEADER, Opcode.DATA_END + 1)
_CHAIN = 3
"""So many records in a row make a place in a damaged file count as the begin of a record."""
_CANDIDATE = re.compile(rb"[\x01-\x0f].{5}\x00{3}", re.DOTALL)


class _Record(NamedTuple):
    opcode: int
    begin: int
    end: int
    """Where the content begins and ends; the end lies behind the file's for a torn record."""


class DamagedMcapFile:
    """An mcap file in whatever state.

    Messages in a chunk whose checksum is wrong are left out: they would be given out for true. So
    are those without a checksum that have a sector of zeros, from the first damaged place on: after
    a power cut, some of what was written last may have reached the disk and some not.

    Parameters
    ----------
    path : Path
        The file; it is only read.

    Attributes
    ----------
    topics : list of TopicMetadata
        Topics declared anywhere in the file, one for each name and type.
    damage : Damage
        What was not understood; complete when :meth:`messages` is exhausted.
    compression : str
        ``zstd`` if a chunk is compressed so, else ``none``.

    Raises
    ------
    OSError
        If the file cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.topics: list[TopicMetadata] = []
        self.damage = Damage()
        self.compression = "none"
        self._path = path
        self._numbers: dict[int, int] = {}
        self._doubtful = self._room = 0
        with path.open("rb") as file:
            # An empty file cannot be mapped.
            self._data: mmap.mmap | bytes = (
                mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) if path.stat().st_size else b""
            )
        self._find_topics()

    def messages(self) -> Iterator[SerializedMessage]:
        """Iterate over the messages in the order of the file."""
        self.damage = Damage()
        for opcode, content in self._records():
            if opcode != Opcode.MESSAGE:
                continue
            if len(content) < _MESSAGE.size:
                self.damage.note("a message is too short", len(content))
                continue
            channel, _, received, sent = _MESSAGE.unpack_from(content)
            number = self._numbers.get(channel)
            if number is None or received >= 2**63:
                self.damage.note(f"a message of an unknown topic {channel}", len(content))
                continue
            yield SerializedMessage(
                number, received, min(sent, 2**63 - 1), content[_MESSAGE.size :]
            )

    def _find_topics(self) -> None:
        schemas: dict[int, Schema] = {}
        channels: dict[int, Channel] = {}
        for opcode, content in self._records():
            try:
                # The first of several is that of the data; the summary at the end repeats them.
                if opcode == Opcode.SCHEMA:
                    schema = Schema.read(ReadDataStream(BytesIO(content)))
                    schemas.setdefault(schema.id, schema)
                elif opcode == Opcode.CHANNEL:
                    channel = Channel.read(ReadDataStream(BytesIO(content)))
                    channels.setdefault(channel.id, channel)
            except (McapError, struct.error, ValueError, MemoryError, OverflowError):
                continue
        for number, channel in channels.items():
            schema_found = schemas.get(channel.schema_id)
            if schema_found is not None and channel.topic and schema_found.name:
                self._numbers[number] = self._add(channel, schema_found)

    def _add(self, channel: Channel, schema: Schema) -> int:
        topic = TopicMetadata(
            channel.topic,
            schema.name,
            schema.data.decode(errors="replace"),
            channel.metadata.get("topic_type_hash", ""),
            channel.metadata.get("offered_qos_profiles", ""),
            schema.encoding,
            channel.message_encoding,
        )
        for number, known in enumerate(self.topics):
            if (known.name, known.message_type) == (topic.name, topic.message_type):
                return number
        self.topics.append(topic)
        return len(self.topics) - 1

    # Records -------------------------------------------------------------------------------

    def _records(self) -> Iterator[tuple[int, bytes]]:
        """Iterate over opcode and content of all records, those in chunks included."""
        data, size = self._data, len(self._data)
        self._doubtful = size
        self._room = allowed_size(size)
        position = len(MCAP_MAGIC)
        if data[:position] != MCAP_MAGIC:
            self.damage.note("the file does not begin as an mcap file does")
            position = 0
        while position < size:
            record = self._record_at(position)
            if record is None:
                if self._is_end(position):
                    return
                position = self._next_record(position)
            elif record.opcode == Opcode.CHUNK:
                position = yield from self._chunk_records(record)
            elif record.end > size:
                position = self._next_record(position)
            else:
                if not self._has_lost_sector(position, record.end):
                    yield record.opcode, bytes(data[record.begin : record.end])
                position = record.end

    def _record_at(self, position: int) -> _Record | None:
        begin = position + _HEADER.size
        if begin > len(self._data):
            return None
        opcode, length = _HEADER.unpack_from(self._data, position)
        return _Record(opcode, begin, begin + length) if opcode in _OPCODES else None

    def _next_record(self, damaged: int) -> int:
        """Return where the next record begins from a damaged place on; the end for none."""
        size = len(self._data)
        self._doubt(damaged)
        place = damaged
        for candidate in _CANDIDATE.finditer(self._data, damaged):
            if self._is_chain(candidate.start()):
                place = candidate.start()
                break
        else:
            place = size
        if place > damaged:
            passed = place - damaged
            self.damage.note(f"byte {damaged}: no record, {passed} bytes", passed)
        return place

    def _doubt(self, damaged: int) -> None:
        self._doubtful = min(self._doubtful, damaged)

    def _has_lost_sector(self, begin: int, end: int) -> bool:
        if begin < self._doubtful or first_lost_sector(self._data, begin, end) == end:
            return False
        self.damage.note(f"byte {begin}: left out: part of it never reached the disk", end - begin)
        return True

    def _is_chain(self, position: int) -> bool:
        for _ in range(_CHAIN):
            record = self._record_at(position)
            if record is None or record.end > len(self._data):
                return self._is_end(position)
            position = record.end
        return True

    def _is_end(self, position: int) -> bool:
        rest = len(self._data) - position
        return rest == len(MCAP_MAGIC) and self._data[position:] == MCAP_MAGIC

    # Chunks --------------------------------------------------------------------------------

    def _chunk_records(self, record: _Record) -> Generator[tuple[int, bytes], None, int]:
        """Iterate over the records of a chunk; of a torn one, over those that are whole.

        Returns
        -------
        int
            Where to go on in the file.
        """
        torn = record.end > len(self._data)
        # Without its checksum, a torn chunk is good up to what never reached the disk.
        end = first_lost_sector(self._data, record.begin, len(self._data)) if torn else record.end
        stored = self._data[record.begin : end]
        place = record.begin - _HEADER.size
        try:
            chunk = self._chunk_content(stored)
        except ValueError as error:
            self.damage.note(f"byte {place}: chunk left out: {error}", 0 if torn else len(stored))
            self._doubt(place)
            return self._next_record(record.begin) if torn else record.end
        if len(chunk.content) == chunk.length:
            damaged = bool(chunk.checksum) and zlib.crc32(chunk.content) != chunk.checksum
        else:
            damaged = not torn
        if damaged:
            self.damage.note(f"byte {place}: chunk left out: its checksum is wrong", len(stored))
            self._doubt(place)
            return min(record.end, len(self._data))
        position = 0
        while position + _HEADER.size <= len(chunk.content):
            opcode, length = _HEADER.unpack_from(chunk.content, position)
            begin, end = position + _HEADER.size, position + _HEADER.size + length
            if opcode not in _OPCODES or end > len(chunk.content):
                if not torn:
                    self.damage.note(f"byte {place}: chunk ends with no record")
                break
            yield opcode, chunk.content[begin:end]
            position = end
        if not torn:
            return record.end
        # Records in the torn chunk itself must not be found once more.
        return self._next_record(
            record.begin + chunk.begin + position if chunk.plain else len(self._data)
        )

    def _chunk_content(self, stored: bytes) -> "_Chunk":
        if len(stored) < _CHUNK.size + 4:
            raise ValueError("its beginning is missing")
        _, _, length, checksum = _CHUNK.unpack_from(stored)
        (name_length,) = struct.unpack_from("<I", stored, _CHUNK.size)
        begin = _CHUNK.size + 4 + name_length + 8
        if name_length > 4 or begin > len(stored) or length > LARGEST_CHUNK:
            raise ValueError("its beginning is damaged")
        name = stored[_CHUNK.size + 4 : begin - 8]
        compressed = stored[begin:]
        if name == b"":
            return _Chunk(compressed[:length], length, checksum, begin, True)
        if length > self._room:
            raise ValueError("the file holds more than one of its size may")
        if name == b"zstd":
            self.compression = "zstd"
            content = decompressed_zstd(compressed, length)
        elif name == b"lz4":
            content = decompressed_lz4(compressed, length)
        else:
            raise ValueError(f"its compression {name!r} is not known")
        self._room -= len(content)
        return _Chunk(content, length, checksum, begin, False)


class _Chunk(NamedTuple):
    """Records of a chunk as far as they go, with the length and checksum that they should have."""

    content: bytes
    length: int
    checksum: int
    begin: int
    plain: bool
