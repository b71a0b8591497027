"""An mcap file that holds, at every commit, all it was given, readable without its end."""

import os
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer

from bdt_bags.writing.metadata_file import metadata_text
from bdt_bags.writing.topic_metadata import BagWriteError, SerializedMessage, TopicMetadata


class McapFile:
    """Writes one mcap file; a commit ends a chunk, which carries a checksum as data and index do.

    The library ``mcap`` encodes into memory, this class carries that to the disk. A disk that is
    full thus leaves the encoder in order: the rest is written when there is space again.

    Parameters
    ----------
    path : Path
        File, which must not exist.
    topics : sequence of TopicMetadata
        Topics of the bag; more may be appended while the file is open.
    compression : str
        ``none`` or ``zstd``, of each chunk.

    Raises
    ------
    BagWriteError
        If the file cannot be created.
    """

    suffix = ".mcap"

    def __init__(self, path: Path, topics: Sequence[TopicMetadata], compression: str) -> None:
        self.path = path
        try:
            self._descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
        except OSError as error:
            raise BagWriteError(error.strerror) from error
        self._topics = topics
        self._schemas: dict[str, int] = {}
        self._channels: list[int] = []
        self._pending = _PendingBytes()
        self._written = self._whole = 0
        self._finished = self._closed = False
        self._open = threading.Lock()
        kind = CompressionType.ZSTD if compression == "zstd" else CompressionType.NONE
        self._writer = Writer(
            self._pending,  # type: ignore[arg-type]
            compression=kind,
            enable_data_crcs=True,
        )
        self._writer.start("ros2")

    @property
    def size(self) -> int:
        """Size of the file [byte]."""
        return self._written

    def append(self, messages: Sequence[SerializedMessage]) -> None:
        """Encode messages; nothing reaches the disk before :meth:`commit`."""
        self._register_topics()
        channels, add = self._channels, self._writer.add_message
        for topic, received, sent, data in messages:
            add(channels[topic], received, data, sent)
        self._writer.flush()

    def commit(self) -> None:
        """Hand to the system what was appended; after a failure, go on where it stopped.

        Raises
        ------
        BagWriteError
            If the disk refuses.
        """
        with memoryview(self._pending.data) as view:
            done = 0
            try:
                while done < len(view):
                    done += os.pwrite(self._descriptor, view[done:], self._written + done)
            except OSError as error:
                raise BagWriteError(error.strerror) from error
            finally:
                self._written += done
                view.release()
                del self._pending.data[:done]
        self._whole = self._written

    def sync(self) -> None:
        """Carry to the disk itself what was committed, so that it survives a power cut.

        May run in another thread than the rest.

        Raises
        ------
        BagWriteError
            If the disk refuses.
        """
        with self._open:
            if self._closed:
                return
            try:
                os.fdatasync(self._descriptor)
            except OSError as error:
                raise BagWriteError(error.strerror) from error

    def finish(self, information: dict[str, Any]) -> None:
        """Write index and end and close the file; may be repeated after a failure.

        Parameters
        ----------
        information : dict
            Description of the bag, see :func:`describe_bag`.

        Raises
        ------
        BagWriteError
            If the disk refuses.
        """
        if not self._finished:
            self._register_topics()
            self._writer.flush()
            self._writer.add_metadata(
                "rosbag2", {"serialized_metadata": metadata_text(information)}
            )
            self._writer.finish()
            self._finished = True
        self.commit()
        self.sync()
        self._close()

    def abandon(self) -> None:
        """Close the file after the last whole chunk, without index and end.

        Raises
        ------
        BagWriteError
            If the disk refuses; the file is closed all the same.
        """
        try:
            os.ftruncate(self._descriptor, self._whole)
            self.sync()
        except OSError as error:
            raise BagWriteError(error.strerror) from error
        finally:
            self._close()

    def _close(self) -> None:
        with self._open:
            self._closed = True
            os.close(self._descriptor)

    def _register_topics(self) -> None:
        for topic in self._topics[len(self._channels) :]:
            if topic.message_type not in self._schemas:
                self._schemas[topic.message_type] = self._writer.register_schema(
                    topic.message_type, topic.definition_encoding, topic.definition.encode()
                )
            self._channels.append(
                self._writer.register_channel(
                    topic.name,
                    topic.serialization_format,
                    self._schemas[topic.message_type],
                    {
                        "offered_qos_profiles": topic.offered_qos,
                        "topic_type_hash": topic.type_hash,
                    },
                )
            )


class _PendingBytes:
    """Stands for the file where the encoder writes: what it wrote and where it is."""

    def __init__(self) -> None:
        self.data = bytearray()
        self._position = 0

    def write(self, data: bytes) -> int:
        self.data += data
        self._position += len(data)
        return len(data)

    def tell(self) -> int:
        return self._position

    def flush(self) -> None:
        """Do nothing: this is memory."""
