"""Whole files of a bag, compressed once they have ended, with a checksum."""

import os
from pathlib import Path

import zstandard

from bdt_bags.bag_format import COMPRESSED_SUFFIX
from bdt_bags.writing.topic_metadata import BagWriteError


def compressed_copy(original: Path) -> Path:
    """Write a compressed copy beside a file, which survives a power cut once its name does.

    Parameters
    ----------
    original : Path
        A file that has ended.

    Returns
    -------
    Path
        The copy.

    Raises
    ------
    BagWriteError
        If the disk refuses; there is no copy then.
    """
    compressed = original.with_name(f"{original.name}{COMPRESSED_SUFFIX}")
    try:
        with original.open("rb") as source, compressed.open("xb") as target:
            zstandard.ZstdCompressor(write_checksum=True).copy_stream(source, target)
            target.flush()
            os.fsync(target.fileno())
    except OSError as error:
        compressed.unlink(missing_ok=True)
        raise BagWriteError(error.strerror) from error
    return compressed
