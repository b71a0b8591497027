"""Bags as bytes: every storage and compression, mcap records to edit."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import lz4.frame
import pytest
from backports import zstd
from rosbags.rosbag2 import CompressionMode, StoragePlugin

MCAP_MAGIC = b"\x89MCAP0\r\n"


@dataclass
class StoredBag:
    """The files of a bag by name; the first one is the storage."""

    files: dict[str, bytes] = field(default_factory=dict)

    def write(self, folder: Path) -> Path:
        folder.mkdir(exist_ok=True)
        for name, content in self.files.items():
            (folder / name).write_bytes(content)
        return folder

    @property
    def storage(self) -> str:
        return next(name for name in self.files if name != "metadata.yaml")


def mcap_records(data: bytes) -> Iterator[tuple[int, int, bytes]]:
    """Yield place, opcode and content of the records of a file."""
    place = len(MCAP_MAGIC)
    while place < len(data) - len(MCAP_MAGIC):
        opcode, length = struct.unpack_from("<BQ", data, place)
        yield place, opcode, data[place + 9 : place + 9 + length]
        place += 9 + length


def mcap_record(opcode: int, content: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(content)) + content


def mcap_chunk(content: bytes, compression: str, *, declared: int | None = None) -> bytes:
    """Return a chunk record; `declared` is its uncompressed size."""
    compressed = {"": bytes, "zstd": zstd.compress, "lz4": lz4.frame.compress}[compression](content)
    return chunk_of(compressed, compression, len(content) if declared is None else declared)


def chunk_of(compressed: bytes, compression: str, declared: int) -> bytes:
    head = struct.pack("<QQQI", 0, 2**62, declared, 0)
    name = struct.pack("<I", len(compression)) + compression.encode()
    return mcap_record(6, head + name + struct.pack("<Q", len(compressed)) + compressed)


def without_summary(data: bytes, compression: str) -> bytes:
    """Return an uncompressed mcap file with other chunks and without its summary."""
    records = []
    for _, opcode, content in mcap_records(data):
        if opcode == 1:
            records.append(mcap_record(1, content))
        if opcode == 6:
            records.append(mcap_chunk(content[40:], compression))
    return MCAP_MAGIC + b"".join([*records, mcap_record(2, bytes(20)), MCAP_MAGIC])


@pytest.fixture(scope="session")
def stored_bags(shortest_loop, tmp_path_factory) -> dict[str, StoredBag]:
    """Return one bag of 0.6 s in every storage and compression."""
    folder = tmp_path_factory.mktemp("stored")
    bags = {}
    for storage in StoragePlugin:
        for mode in CompressionMode:
            if mode is CompressionMode.STORAGE and storage is StoragePlugin.SQLITE3:
                continue
            path = shortest_loop.write(
                folder / f"{storage.name}_{mode.name}".lower(), storage=storage, compression=mode
            )
            files = {x.name: x.read_bytes() for x in sorted(path.iterdir(), reverse=True)}
            bags[path.name] = StoredBag(files)
    plain = bags["mcap_none"]
    bags["mcap_lz4"] = StoredBag(
        {**plain.files, plain.storage: without_summary(plain.files[plain.storage], "lz4")}
    )
    return bags


class Mcap:
    """What it takes to build mcap files by bytes."""

    magic = MCAP_MAGIC
    record = staticmethod(mcap_record)
    records = staticmethod(mcap_records)
    chunk = staticmethod(mcap_chunk)
    chunk_of = staticmethod(chunk_of)

    @staticmethod
    def file(*records: bytes) -> bytes:
        return MCAP_MAGIC + b"".join([*records, mcap_record(2, bytes(20)), MCAP_MAGIC])


@pytest.fixture
def mcap() -> type[Mcap]:
    return Mcap
