"""Opening bags, with errors that a user can read."""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ros2cli.errors import CommandError

__all__ = ["STORAGES", "add_bag_arguments", "open_bag"]

STORAGES = ("mcap", "sqlite3")
_SUFFIXES = {".mcap": "mcap", ".db3": "sqlite3"}


def add_bag_arguments(verb: argparse.ArgumentParser) -> None:
    """Add the arguments that name a bag."""
    verb.add_argument("bag_path", type=_existing, help="Bag to open")
    verb.add_argument(
        "-s", "--storage", choices=STORAGES, help="Storage of the bag; found out by default"
    )


def _existing(text: str) -> str:
    if not Path(text).exists():
        raise argparse.ArgumentTypeError(f"Bag path '{text}' does not exist!")
    return text


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
        raise CommandError(f"Could not find metadata in bag directory {path}")
    if path.is_file() and _SUFFIXES.get(path.suffix) != (storage or _SUFFIXES.get(path.suffix, "")):
        raise CommandError(f"No plugin detected that could open file {path}")
    try:
        reader = Reader(path)
        reader.open()
    except (ReaderError, OSError, AssertionError) as error:
        reason = " ".join(str(error).split()) or "it is damaged"
        raise CommandError(f"Could not open bag {path}: {reason}") from None
    try:
        yield reader
    except ReaderError as error:
        raise CommandError(f"Could not read bag {path}: {' '.join(str(error).split())}") from None
    finally:
        reader.close()
