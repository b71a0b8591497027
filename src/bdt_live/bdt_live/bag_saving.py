"""Saves the last minute as a bag, in a thread, under a name that no page chooses."""

import threading
from datetime import datetime
from pathlib import Path
from queue import Empty, SimpleQueue

from bdt_bags.writing.topic_metadata import BagWriteError, SerializedMessage, TopicMetadata
from bdt_live.recent_messages import RecentMessages, write_bag


class BagSaving:
    """Saves one bag at a time.

    Parameters
    ----------
    folder : Path
        Where bags go.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._outcomes: SimpleQueue[tuple[str, str | None]] = SimpleQueue()
        self._thread: threading.Thread | None = None

    def begin(self, recent: RecentMessages) -> str | None:
        """Begin to save; return why not, if so."""
        if self._thread is not None:
            return "a bag is being saved"
        messages = recent.messages()
        if not messages:
            return "nothing has been said yet"
        name = f"bag-{datetime.now().astimezone():%Y%m%d-%H%M%S-%f}"
        work = (name, list(recent.topics), messages)
        self._thread = threading.Thread(target=self._save, args=work)
        self._thread.start()
        return None

    def outcome(self) -> tuple[str, str | None] | None:
        """Return name and fault of a bag that has been saved; None while there is none."""
        try:
            outcome = self._outcomes.get_nowait()
        except Empty:
            return None
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        return outcome

    def _save(
        self, name: str, topics: list[TopicMetadata], messages: list[SerializedMessage]
    ) -> None:
        try:
            write_bag(self._folder / name, topics, messages)
        except (OSError, BagWriteError) as error:
            self._outcomes.put((name, str(error)))
        else:
            self._outcomes.put((name, None))
