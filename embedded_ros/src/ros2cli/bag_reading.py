"""Opening bags, with errors that a user can read."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ros2cli.errors import CommandError

__all__ = ["messages_of", "open_bag"]

_STORAGES = {".mcap": "mcap", ".db3": "sqlite3"}


@contextmanager
def open_bag(path: Path, storage: str | None) -> Iterator[Any]:
    """Open a bag: a folder with ``metadata.yaml`` or a single storage file.

    Yields
    ------
    rosbags.rosbag2.Reader
    """
    # Imported here: it takes longer than all other commands need to start.
    from rosbags.rosbag2 import Reader

    if path.is_dir() and not (path / "metadata.yaml").is_file():
        raise CommandError(f"{path} is no bag: it has no metadata.yaml")
    if path.is_file():
        found = _STORAGES.get(path.suffix)
        if found is None or found != (storage or found):
            raise CommandError(f"{path} is no {storage or 'mcap or sqlite3'} file by its name")
    with _damage_told(f"Could not open bag {path}"):
        reader = Reader(path)
        reader.open()
    try:
        yield reader
    finally:
        reader.close()


def messages_of(
    reader: Any, connections: Sequence[Any], start: int, stop: int | None
) -> Iterator[tuple[Any, int, bytes]]:
    """Connections, times in ns and bytes of the messages from `start` on and before `stop`."""
    with _damage_told(f"Could not read bag {reader.path}"):
        yield from reader.messages(connections, start, stop)


@contextmanager
def _damage_told(complaint: str) -> Iterator[None]:
    try:
        yield
    except Exception as error:  # noqa: BLE001 - damaged bytes lead rosbags to any error
        raise CommandError(f"{complaint}: {str(error) or 'it is damaged'}") from None
