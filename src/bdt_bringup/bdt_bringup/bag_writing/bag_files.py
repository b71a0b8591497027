"""A bag folder that is being written: files, their splitting, metadata.yaml."""

import os
from collections import Counter
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bdt_bringup.bag_writing.durable_folder import create_folder, sync_folder
from bdt_bringup.bag_writing.metadata_file import (
    UNFINISHED,
    FileSpan,
    describe_bag,
    write_metadata,
)
from bdt_bringup.bag_writing.recorded_topic import BagWriteError, Message, RecordedTopic
from bdt_bringup.bag_writing.sqlite_file import SqliteFile

if TYPE_CHECKING:
    from bdt_bringup.bag_writing.mcap_file import McapFile

NEEDS = {"mcap": "mcap", "zstd": "zstandard"}
"""Python packages behind storages and compressions; a ROS 2 installation may lack them."""

SMALLEST_PIECE = 1 << 16
"""Messages between two looks at the size of a file that is to be split [byte]."""
MESSAGE_OVERHEAD = 50
"""What a message takes in a file besides its content, roughly [byte]."""


class BagFiles:
    """Writes a bag in the caller's thread.

    ``metadata.yaml`` is there from the first commit on and is renewed when a file is added, so that
    a bag whose recorder was killed can be opened. While a disk is full, what was appended stays
    in memory; :meth:`commit` may be repeated.

    Parameters
    ----------
    folder : Path
        Folder of the bag, which must not exist.
    storage : str
        ``mcap`` or ``sqlite3``.
    compression : str
        ``none`` or ``zstd``: of the chunks of an mcap, of whole sqlite3 files once the bag is
        closed. ROS 2 reads both by itself.
    split_size : int
        Size from which on a new file is begun [byte]; 0 for one file.
    split_duration : float
        Time of reception between first and last message of a file [s]; 0 for one file.

    Raises
    ------
    OSError
        If the folder exists or cannot be created.
    BagWriteError
        If the first file cannot be created, or a package is missing that writes it.
    """

    def __init__(
        self,
        folder: Path,
        *,
        storage: str = "mcap",
        compression: str = "none",
        split_size: int = 0,
        split_duration: float = 0.0,
    ) -> None:
        for choice in (storage, compression):
            package = NEEDS.get(choice)
            if package is not None and find_spec(package) is None:
                raise BagWriteError(f"{choice} needs the Python package {package}")
        create_folder(folder.parent)
        folder.mkdir()
        sync_folder(folder.parent)
        self.folder = folder
        self.storage = storage
        self.topics: list[RecordedTopic] = []
        self.spans: list[FileSpan] = []
        self._compression = compression
        self._split_size = split_size
        self._split_duration = round(split_duration * 1e9)
        self._counts: Counter[int] = Counter()
        self._waiting: list[Message] = []
        self._in_flight: list[Message] = []
        self._described = (-1, -1)
        self._file: McapFile | SqliteFile | None = None
        self._begin_file()

    @property
    def message_count(self) -> int:
        """Number of messages that were committed."""
        return self._counts.total()

    @property
    def unwritten(self) -> list[Message]:
        """Messages that were appended but not committed, because the disk refused them."""
        return self._in_flight + self._waiting

    def add_topic(self, topic: RecordedTopic) -> int:
        """Add a topic and return its number; any thread may, at any time."""
        self.topics.append(topic)
        return len(self.topics) - 1

    def append(self, messages: Sequence[Message]) -> None:
        """Take messages in the order of their reception; :meth:`commit` writes them."""
        self._waiting += messages

    def commit(self) -> None:
        """Hand everything that was appended to the system, split as wanted.

        Raises
        ------
        BagWriteError
            If the disk refuses; the rest is kept.
        """
        if self._file is None:
            self._begin_file()
        self._commit_file()
        while self._waiting:
            if self._is_full(self._waiting[0]):
                self.split()
            self._in_flight = self._next_piece()
            del self._waiting[: len(self._in_flight)]
            self._current.append(self._in_flight)
            self._commit_file()
        if self._described != (len(self.topics), len(self.spans)):
            self._write_metadata(UNFINISHED)

    def sync(self) -> None:
        """Make what was committed survive a power cut; another thread may."""
        file = self._file
        if file is not None:
            file.sync()

    def split(self) -> None:
        """End the file and begin the next one.

        Raises
        ------
        BagWriteError
            If the disk refuses; the next commit tries again.
        """
        self._current.finish(self._describe({}))
        self._file = None
        self._begin_file()

    def close(self, custom_data: Mapping[str, str] | None = None) -> None:
        """Write everything, end the last file and describe the bag.

        Parameters
        ----------
        custom_data : mapping of str to str, optional
            Goes into the metadata.

        Raises
        ------
        BagWriteError
            If the disk refuses; the bag is then left as :meth:`abandon` leaves it.
        """
        custom = custom_data or {}
        try:
            self.commit()
            self._current.finish(self._describe(custom))
            self._file = None
            if self.storage == "sqlite3" and self._compression == "zstd":
                self._compress_files(custom)
            else:
                self._write_metadata(custom)
        except BagWriteError:
            self.abandon()
            raise

    def abandon(self) -> None:
        """Close the last file as it is; what is in it can be recovered, also after a power cut.

        Raises
        ------
        BagWriteError
            If the disk refuses even that.
        """
        file, self._file = self._file, None
        if file is not None:
            file.abandon()

    @property
    def _current(self) -> "McapFile | SqliteFile":
        if self._file is None:
            raise BagWriteError("the bag is closed")
        return self._file

    def _begin_file(self) -> None:
        stem = f"{self.folder.name}_{len(self.spans)}"
        if self.storage == "mcap":
            from bdt_bringup.bag_writing.mcap_file import McapFile  # noqa: PLC0415

            path = self.folder / f"{stem}{McapFile.suffix}"
            self._file = McapFile(path, self.topics, self._compression)
        else:
            path = self.folder / f"{stem}{SqliteFile.suffix}"
            self._file = SqliteFile(path, self.topics)
        self.spans.append(FileSpan(path.name))
        self._sync_folder()

    def _commit_file(self) -> None:
        self._current.commit()
        for message in self._in_flight:
            self._counts[message.topic] += 1
            self.spans[-1].add(message.received)
        self._in_flight = []

    def _is_full(self, message: Message) -> bool:
        span = self.spans[-1]
        if not span.message_count:
            return False
        if self._split_size and self._current.size >= self._split_size:
            return True
        return bool(self._split_duration) and message.received >= span.start + self._split_duration

    def _next_piece(self) -> list[Message]:
        """Return what of the waiting messages goes into this file before the next look at it."""
        waiting = self._waiting
        if not self._split_size and not self._split_duration:
            return waiting[:]
        span = self.spans[-1]
        start = span.start if span.message_count else waiting[0].received
        end = start + self._split_duration if self._split_duration else float("inf")
        room = max(self._split_size - self._current.size, SMALLEST_PIECE)
        for number, message in enumerate(waiting):
            room -= len(message.data) + MESSAGE_OVERHEAD
            if number and message.received >= end:
                return waiting[:number]
            if self._split_size and room < 0:
                return waiting[: number + 1]
        return waiting[:]

    def _describe(self, custom: Mapping[str, str], file_compression: str = "") -> dict[str, Any]:
        return describe_bag(
            self.storage,
            self.topics,
            self._counts,
            self.spans,
            custom,
            file_compression=file_compression,
        )

    def _write_metadata(self, custom: Mapping[str, str], file_compression: str = "") -> None:
        described = (len(self.topics), len(self.spans))
        try:
            write_metadata(self.folder, self._describe(custom, file_compression))
        except OSError as error:
            raise BagWriteError(error.strerror) from error
        self._described = described

    def _compress_files(self, custom: Mapping[str, str]) -> None:
        import zstandard  # noqa: PLC0415

        # Until the metadata name the compressed files, they name the others, which are all there.
        originals = [self.folder / span.name for span in self.spans]
        for span, original in zip(self.spans, originals, strict=True):
            compressed = original.with_name(f"{original.name}.zstd")
            try:
                with original.open("rb") as source, compressed.open("xb") as target:
                    zstandard.ZstdCompressor().copy_stream(source, target)
                    target.flush()
                    os.fsync(target.fileno())
            except OSError as error:
                compressed.unlink(missing_ok=True)
                raise BagWriteError(error.strerror) from error
            span.name = compressed.name
        # The names must be on the disk before the metadata that refer to them.
        self._sync_folder()
        self._write_metadata(custom, "zstd")
        for original in originals:
            original.unlink()

    def _sync_folder(self) -> None:
        try:
            sync_folder(self.folder)
        except OSError as error:
            raise BagWriteError(error.strerror) from error
