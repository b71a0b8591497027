"""Folders whose names survive a power cut: syncing a file does not carry its name to the disk."""

import os
from pathlib import Path


def create_folder(folder: Path) -> None:
    """Create a folder with all above it, where they are missing, so that they survive a power cut.

    Raises
    ------
    OSError
        If a folder cannot be created or synced.
    """
    missing = [one for one in (folder, *folder.parents) if not one.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    for one in reversed(missing):
        sync_folder(one.parent)


def sync_folder(folder: Path) -> None:
    """Make the names in a folder survive a power cut.

    Raises
    ------
    OSError
        If the folder cannot be read, or the disk refuses.
    """
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
