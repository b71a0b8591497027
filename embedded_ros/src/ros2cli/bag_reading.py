"""Opening bags, with errors that a user can read."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ros2cli.errors import CommandError

__all__ = ["open_bag"]

_STORAGES = {".mcap": "mcap", ".db3": "sqlite3"}


@contextmanager
def open_bag(path: Path, storage: str | None) -> Iterator[Any]:
    """Open a bag: a folder with ``metadata.yaml`` or a single storage file.

    Yields
    ------
    rosbags.rosbag2.Reader
    """
    # Imported here: it takes longer than all other commands need to start.
    from rosbags.rosbag2 import Reader, ReaderError

    if path.is_dir() and not (path / "metadata.yaml").is_file():
        raise CommandError(f"{path} is no bag: it has no metadata.yaml")
    if path.is_file():
        found = _STORAGES.get(path.suffix)
        if found is None or found != (storage or found):
            raise CommandError(f"{path} is no {storage or 'mcap or sqlite3'} file by its name")
    try:
        reader = Reader(path)
        reader.open()
    except (ReaderError, OSError, AssertionError) as error:
        raise CommandError(f"Could not open bag {path}: {str(error) or 'it is damaged'}") from None
    try:
        yield reader
    except ReaderError as error:
        raise CommandError(f"Could not read bag {path}: {error}") from None
    finally:
        reader.close()
