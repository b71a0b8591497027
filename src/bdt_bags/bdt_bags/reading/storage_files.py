"""From a path to checked mcap and sqlite3 files that may be read."""

import os
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from bdt_bags.bag_error import BagError
from bdt_bags.bag_format import (
    COMPRESSED_SUFFIX,
    MCAP_MAGIC,
    METADATA_FILE,
    SQLITE_MAGIC,
    STORAGE_OF_SUFFIX,
)
from bdt_bags.file_checksums import file_checksum
from bdt_bags.reading.bounded_decompression import ZSTD_MAGIC, decompress_file
from bdt_bags.reading.mcap_check import check_mcap
from bdt_bags.reading.metadata_file import RecordedFile, recorded_files
from bdt_bags.reading.sqlite_check import check_sqlite

ROS_1_MAGIC = b"#ROSBAG V"
SUFFIXES = (*STORAGE_OF_SUFFIX, COMPRESSED_SUFFIX)

DAMAGED = (
    "is damaged",
    "is cut off",
    "has no end",
    "has a damaged",
    "is a damaged",
    "is not an intact",
    "record at byte",
    "chunk",
    "zstd data is damaged",
    "lz4 data is damaged",
)
"""How errors begin of a file that may hold messages all the same."""


def recovery_hint(bag: Path) -> str:
    """Return what there is to do about a damaged bag, to be put behind the error."""
    return f"; bdt recover {bag} makes a whole bag of what is left"


@contextmanager
def storage_files(path: Path) -> Iterator[list[Path]]:
    """Give the storage files of a bag, checked, decompressed if necessary, with the right suffix.

    What a file is tells its content, not its name. Copies lie in a temporary folder as long as
    the context lasts; the bag itself is only opened for reading.

    Parameters
    ----------
    path : Path
        A rosbag2 folder or one of its files.

    Yields
    ------
    list of Path
        ``.mcap`` or ``.db3`` files in the order of the bag.

    Raises
    ------
    BagError
        If this is no bag or a file of it is damaged.
    OSError
        If something cannot be read.
    """
    files = _recorded_files(path)
    with TemporaryDirectory(prefix="bdt_bag_") as folder:
        yield [
            _readable(path, recorded, Path(folder) / str(number))
            for number, recorded in enumerate(files)
        ]


def _recorded_files(path: Path) -> list[RecordedFile]:
    if not os.path.lexists(path):
        raise BagError(f"bag {path}: does not exist")
    if path.is_dir():
        if (path / METADATA_FILE).is_file():
            try:
                return recorded_files(path)
            except BagError as error:
                raise BagError(f"bag {path}: {error}") from None
        names = sorted(x.name for x in path.iterdir() if x.suffix in SUFFIXES)
        hint = f"; {path / names[0]} can be given by itself" if names else ""
        if len(names) > 1:
            hint = f"; it has {len(names)} storage files, each can be given by itself"
        raise BagError(
            f"bag {path}: has no {METADATA_FILE}: "
            f"must be a rosbag2 folder, a .mcap or a .db3 file{hint}"
        )
    if not path.is_file():  # a pipe or a device could be read for ever
        path.stat()
        raise BagError(f"bag {path}: must be a rosbag2 folder or an ordinary file")
    return [RecordedFile(path, "")]


def _readable(bag: Path, recorded: RecordedFile, copy: Path) -> Path:
    """Return a file that has been checked: the file itself or a copy of it."""
    file = recorded.path
    name = "" if file == bag else f"{file.name}: "
    try:
        _check_checksum(recorded)
        kind = _magic(file)
        if kind.startswith(ZSTD_MAGIC):
            decompressed = copy.with_suffix(".decompressed")
            decompress_file(file, decompressed)
            file, kind = decompressed, _magic(decompressed)
        suffix = _suffix(kind)
        if suffix == ".db3" and _size(log := file.with_name(f"{file.name}-wal")):
            file = _with_log(file, log, copy.with_suffix(suffix))
        if suffix == ".db3":
            check_sqlite(file)
        else:
            check_mcap(file)
    except BagError as error:
        hint = recovery_hint(bag) if str(error).startswith(DAMAGED) else ""
        raise BagError(f"bag {bag}: {name}{error}{hint}") from None
    # The reader tells files by their suffix, and gives sqlite the name as an URI, unquoted.
    if file.suffix != suffix or set("?#%") & set(str(file)):
        link = copy.with_suffix(suffix)
        link.symlink_to(file.resolve())
        return link
    return file


def _check_checksum(recorded: RecordedFile) -> None:
    if recorded.checksum and recorded.checksum != f"{file_checksum(recorded.path):08x}":
        raise BagError("is damaged or was changed: it has another checksum than its metadata say")


def _suffix(kind: bytes) -> str:
    if kind.startswith(MCAP_MAGIC):
        return ".mcap"
    if kind.startswith(SQLITE_MAGIC):
        return ".db3"
    if not kind:
        raise BagError("is empty: must be an mcap or a sqlite3 file")
    if kind.startswith(ROS_1_MAGIC):
        raise BagError("is a ROS 1 bag: convert it with rosbags-convert --src FILE --dst FOLDER")
    raise BagError("is neither an mcap nor a sqlite3 file: must be a rosbag2 folder, .mcap or .db3")


def _magic(file: Path) -> bytes:
    with file.open("rb") as content:
        return content.read(16)


def _size(file: Path) -> int:
    return file.stat().st_size if file.is_file() else 0


def _with_log(file: Path, log: Path, copy: Path) -> Path:
    """Copy a database whose recorder was killed, with the messages that only its log has."""
    shutil.copyfile(file, copy)
    shutil.copyfile(log, copy.with_name(f"{copy.name}-wal"))
    try:
        with closing(sqlite3.connect(copy)) as connection:
            connection.execute("PRAGMA journal_mode = DELETE").fetchone()
    except sqlite3.Error as error:
        raise BagError(f"has a damaged log {log.name}: {error}") from None
    return copy
