"""Writes a bag in threads of its own: whoever records never waits for the disk."""

import math
import threading
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

from bdt_bags.writing.bag_files import BagFiles
from bdt_bags.writing.topic_metadata import BagWriteError, SerializedMessage, TopicMetadata

COMMIT_PERIOD = 0.25
"""Time between two commits, which hand messages to the system [s]."""
QUEUE_LIMIT = 64 << 20
"""Messages that may wait for a slow or full disk [byte]; what comes then is dropped and counted."""
_EARLY_COMMIT = 1 << 20


class BackgroundWriter:
    """Takes messages and hands them to the system within :data:`COMMIT_PERIOD`.

    One thread encodes and writes, one carries what was written to the disk itself and ends files
    that are full. The first never waits for the second.

    What the system has survives the end of the process, so ``kill -9`` loses one commit period
    and the time for which the first thread gets no processor or stands in a system call that
    writes: a disk takes as long to store as it likes, as long as the system takes the data
    meanwhile. The sqlite3 storage syncs once every 4 MB in that thread. How long messages have
    waited altogether is measured, see `longest_wait`.

    What the disk has stored survives a power cut. The second thread starts anew as soon as it is
    done, so a power cut loses what a kill does and the time of two syncs: the one that was under
    way, and the one that would have been next.

    Parameters
    ----------
    files : BagFiles
        The bag; belongs to this object from here on.
    report : callable
        Takes one line about the disk, called by the writing thread when trouble begins or ends.
    queue_limit : int
        See :data:`QUEUE_LIMIT`.

    Attributes
    ----------
    dropped : Counter of int
        Messages that were dropped because the disk was too slow or full, by topic number.
    longest_wait : float
        Longest time from the moment when a message was taken to the one when the system had it
        [s]: what a kill could have cost so far.
    """

    def __init__(
        self,
        files: BagFiles,
        report: Callable[[str], object],
        queue_limit: int = QUEUE_LIMIT,
    ) -> None:
        self.dropped: Counter[int] = Counter()
        self.longest_wait = 0.0
        self._files = files
        self._report = report
        self._queue_limit = queue_limit
        self._lock = threading.Lock()
        self._queue: list[SerializedMessage] = []
        self._queued_bytes = 0
        self._queued_since = self._unwritten_since = math.inf
        self._wake = threading.Event()
        self._stopping = False
        self._disk_error = ""
        self._failure: BaseException | None = None
        self._sync_thread = ThreadPoolExecutor(1, "bag_sync")
        self._sync: Future[None] | None = None
        self._thread = threading.Thread(target=self._run, name="bag_writer", daemon=True)
        self._thread.start()

    @property
    def disk_error(self) -> str:
        """What keeps the disk from taking messages; "" while it takes them."""
        return self._disk_error

    @property
    def message_count(self) -> int:
        """Number of messages that the system has taken."""
        return self._files.message_count

    def add_topic(self, topic: TopicMetadata) -> int:
        """Add a topic and return its number."""
        return self._files.add_topic(topic)

    def write(self, topic: int, received: int, data: bytes) -> None:
        """Take a message; returns at once, whatever the disk does.

        Parameters
        ----------
        topic : int
            Number of the topic, see :meth:`add_topic`.
        received : int
            Time of reception [ns].
        data : bytes
            Serialized message.
        """
        if self._failure is not None:
            raise self._failure
        with self._lock:
            if self._queued_bytes + len(data) > self._queue_limit:
                self.dropped[topic] += 1
                return
            if not self._queue:
                self._queued_since = time.monotonic()
            self._queue.append(SerializedMessage(topic, received, received, data))
            before = self._queued_bytes
            self._queued_bytes += len(data)
        if before < _EARLY_COMMIT <= self._queued_bytes:
            self._wake.set()

    def close(self, custom_data: dict[str, str]) -> None:
        """Write what is left and close the bag.

        Parameters
        ----------
        custom_data : dict
            Goes into the metadata, with the number of messages dropped and the longest wait.

        Raises
        ------
        BagWriteError
            If the disk refuses the rest; what it took before can be recovered.
        """
        self._stopping = True
        self._wake.set()
        self._thread.join()
        self._sync_thread.shutdown()
        unsynced = self._sync.exception() if self._sync is not None else None
        if isinstance(unsynced, BagWriteError):
            self._report_disk_error(unsynced)
        elif unsynced is not None and self._failure is None:
            self._failure = unsynced
        if self._failure is not None:
            self._files.abandon()
            raise self._failure
        self._files.append(self._take_queue())
        measured = {
            "messages_dropped": str(self.dropped.total()),
            "longest_wait_s": f"{self.longest_wait:.3f}",
        }
        try:
            self._files.close({**custom_data, **measured})
        except BagWriteError:
            self.dropped.update(message.topic for message in self._files.unwritten)
            raise

    def _run(self) -> None:
        try:
            due = time.monotonic() + COMMIT_PERIOD
            while not self._stopping:
                self._wake.wait(max(due - time.monotonic(), 0.0))
                self._wake.clear()
                # A commit that took longer than its period is followed by the next one at once.
                due = time.monotonic() + COMMIT_PERIOD
                self._write_out()
        except Exception as error:  # noqa: BLE001
            # Raised to whoever writes or closes; here nobody would hear it.
            self._failure = error

    def _write_out(self) -> None:
        try:
            # What the disk refused before goes first; until then the queue stays, and is bounded.
            if self._files.unwritten:
                self._files.commit()
            self._files.append(self._take_queue())
            self._files.commit()
            self._note_wait()
            self._sync_in_background()
        except BagWriteError as error:
            self._report_disk_error(error)
        else:
            if self._disk_error:
                self._report(
                    f"{self._files.folder} can be written again: "
                    f"{self.dropped.total()} messages were dropped"
                )
            self._disk_error = ""

    def _report_disk_error(self, error: BagWriteError) -> None:
        if not self._disk_error:
            self._report(
                f"cannot write {self._files.folder}: {error}: what is recorded so far is kept, "
                "what comes is kept in memory as long as possible, then dropped"
            )
        self._disk_error = str(error)

    def _sync_in_background(self) -> None:
        """Begin a sync if none is under way, and raise what the one before has met."""
        before = self._sync
        # Trouble is over only when a sync says so.
        if before is not None and not before.done() and not self._disk_error:
            return
        self._sync = self._sync_thread.submit(self._files.sync)
        if before is not None:
            before.result()

    def _take_queue(self) -> list[SerializedMessage]:
        with self._lock:
            taken, self._queue = self._queue, []
            self._queued_bytes = 0
            self._unwritten_since = min(self._unwritten_since, self._queued_since)
            self._queued_since = math.inf
        return taken

    def _note_wait(self) -> None:
        """Note how long the oldest message of a commit has waited for it."""
        self.longest_wait = max(self.longest_wait, time.monotonic() - self._unwritten_since)
        self._unwritten_since = math.inf
