"""A bag folder that is being written: files, their splitting, metadata.yaml."""

import threading
from collections import Counter, deque
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bdt_bags.file_checksums import checksum_entry
from bdt_bags.writing.file_splitting import FileSplitting
from bdt_bags.writing.metadata_file import (
    UNFINISHED,
    FileInformation,
    describe_bag,
    write_metadata,
)
from bdt_bags.writing.sqlite_file import SqliteFile
from bdt_bags.writing.topic_metadata import BagWriteError, SerializedMessage, TopicMetadata
from bdt_msgs_py.folder_sync import create_folder, sync_folder

if TYPE_CHECKING:
    from bdt_bags.writing.mcap_file import McapFile

NEEDS = {"mcap": "mcap", "zstd": "zstandard"}
"""Python packages behind storages and compressions; a ROS 2 installation may lack them."""


class BagFiles:
    """Writes a bag in the caller's threads: one that commits, and one that syncs if wanted.

    A commit hands messages to the system and waits for no disk. Everything that does is left to
    :meth:`sync`: files that are full are ended there, and ``metadata.yaml`` is written, from the
    first time on and when a file is added, so that a bag whose recorder was killed can be opened.
    While a disk is full, what was appended stays in memory; both may be repeated.

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
        self.topics: list[TopicMetadata] = []
        self.spans: list[FileInformation] = []
        self._compression = compression
        self._splitting = FileSplitting(split_size, round(split_duration * 1e9))
        self._counts: Counter[int] = Counter()
        self._waiting: list[SerializedMessage] = []
        self._in_flight: list[SerializedMessage] = []
        self._described = (-1, -1)
        self._file: McapFile | SqliteFile | None = None
        self._ended: deque[tuple[McapFile | SqliteFile, dict[str, Any]]] = deque()
        self._due_metadata: dict[str, Any] | None = None
        self._synced_names = 0
        self._syncing = threading.Lock()
        self._begin_file()

    @property
    def message_count(self) -> int:
        """Number of messages that were committed."""
        return self._counts.total()

    @property
    def unwritten(self) -> list[SerializedMessage]:
        """Messages that were appended but not committed, because the disk refused them."""
        return self._in_flight + self._waiting

    def add_topic(self, topic: TopicMetadata) -> int:
        """Add a topic and return its number; any thread may, at any time."""
        self.topics.append(topic)
        return len(self.topics) - 1

    def append(self, messages: Sequence[SerializedMessage]) -> None:
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
            if self._splitting.is_full(self.spans[-1], self._current.size, self._waiting[0]):
                self.split()
            self._in_flight = self._splitting.next_piece(
                self.spans[-1], self._current.size, self._waiting
            )
            del self._waiting[: len(self._in_flight)]
            self._current.append(self._in_flight)
            self._commit_file()
        described = (len(self.topics), len(self.spans))
        if self._described != described:
            self._due_metadata = self._describe(UNFINISHED)
            self._described = described

    def sync(self) -> None:
        """Make what was committed survive a power cut, and end files; another thread may.

        Raises
        ------
        BagWriteError
            If the disk refuses; the next sync tries again.
        """
        with self._syncing:
            # Before the files that have ended: this one may become one of them meanwhile.
            current, names = self._file, len(self.spans)
            try:
                self._sync_files(current)
                self._sync_descriptions(names)
            except BagWriteError:
                _check_presence(current)  # if it is gone, this is why, and better to say
                raise

    def _sync_files(self, current: "McapFile | SqliteFile | None") -> None:
        while self._ended:
            file, information = self._ended[0]
            file.finish(information)
            self._ended.popleft()
        if current is not None:
            # The system goes on to take what nobody will ever find.
            _check_presence(current)
            current.sync()

    def _sync_descriptions(self, names: int) -> None:
        if self._synced_names < names:
            self._sync_folder()
            self._synced_names = names
        due = self._due_metadata
        if due is not None:
            write_metadata(self.folder, due)
            if self._due_metadata is due:
                self._due_metadata = None

    def split(self) -> None:
        """Leave the file to :meth:`sync` and begin the next one.

        Raises
        ------
        BagWriteError
            If the disk refuses; the next commit tries again.
        """
        self._end_file({})
        self._begin_file()

    def close(self, custom_data: Mapping[str, str] | None = None) -> None:
        """Write everything, end the files and describe the bag.

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
            self._end_file(custom)
            self.sync()
            if self.storage == "sqlite3" and self._compression == "zstd":
                self._compress_files(custom)
            elif self.storage == "sqlite3":
                write_metadata(self.folder, self._describe({**custom, **self._checksums()}))
            else:
                write_metadata(self.folder, self._describe(custom))
        except BagWriteError:
            self.abandon()
            raise

    def abandon(self) -> None:
        """Close the files as they are; what is in them can be recovered, also after a power cut.

        Raises
        ------
        BagWriteError
            If the disk refuses even that.
        """
        with self._syncing:
            files = [file for file, _ in self._ended]
            self._ended.clear()
            if self._file is not None:
                files.append(self._file)
                self._file = None
            with ExitStack() as all_of_them:
                if self._synced_names < len(self.spans):
                    all_of_them.callback(self._sync_folder)  # comes last
                for file in files:
                    all_of_them.callback(file.abandon)

    def _end_file(self, custom: Mapping[str, str]) -> None:
        self._ended.append((self._current, self._describe(custom)))
        self._file = None

    @property
    def _current(self) -> "McapFile | SqliteFile":
        if self._file is None:
            raise BagWriteError("the bag is closed")
        return self._file

    def _begin_file(self) -> None:
        stem = f"{self.folder.name}_{len(self.spans)}"
        if self.storage == "mcap":
            from bdt_bags.writing.mcap_file import McapFile  # noqa: PLC0415

            path = self.folder / f"{stem}{McapFile.suffix}"
            self._file = McapFile(path, self.topics, self._compression)
        else:
            path = self.folder / f"{stem}{SqliteFile.suffix}"
            self._file = SqliteFile(path, self.topics)
        self.spans.append(FileInformation(path.name))

    def _commit_file(self) -> None:
        self._current.commit()
        for message in self._in_flight:
            self._counts[message.topic] += 1
            self.spans[-1].add(message.received)
        self._in_flight = []

    def _describe(self, custom: Mapping[str, str], file_compression: str = "") -> dict[str, Any]:
        parts = self.storage, self.topics, self._counts, self.spans, custom
        return describe_bag(*parts, file_compression=file_compression)

    def _compress_files(self, custom: Mapping[str, str]) -> None:
        from bdt_bags.writing.file_compression import compressed_copy  # noqa: PLC0415

        # Until the metadata name the compressed files, they name the others, which are all there.
        originals = [self.folder / span.name for span in self.spans]
        for span, original in zip(self.spans, originals, strict=True):
            span.name = compressed_copy(original).name
        # The names must be on the disk before the metadata that refer to them.
        self._sync_folder()
        write_metadata(self.folder, self._describe(custom, "zstd"))
        for original in originals:
            original.unlink()

    def _checksums(self) -> dict[str, str]:
        """Return the checksums of files that have none in them."""
        try:
            return dict(checksum_entry(self.folder / span.name) for span in self.spans)
        except OSError as error:
            raise BagWriteError(error.strerror) from error

    def _sync_folder(self) -> None:
        try:
            sync_folder(self.folder)
        except OSError as error:
            raise BagWriteError(error.strerror) from error


def _check_presence(file: "McapFile | SqliteFile | None") -> None:
    if file is not None and not file.path.exists():
        raise BagWriteError(f"{file.path.name} was deleted or moved")
