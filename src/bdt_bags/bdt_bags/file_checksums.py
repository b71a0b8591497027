"""Checksums of whole files, where their format has none: an uncompressed sqlite3 file."""

import zlib
from pathlib import Path

PREFIX = "crc32 of "
"""In the ``custom_data`` of ``metadata.yaml``, followed by the name of the file."""

_PIECE = 2**20


def checksum_entry(file: Path) -> tuple[str, str]:
    """Return key and value that tell the checksum of a file.

    Raises
    ------
    OSError
        If the file cannot be read.
    """
    return f"{PREFIX}{file.name}", f"{file_checksum(file):08x}"


def file_checksum(file: Path) -> int:
    """Return the CRC-32 of a file.

    Raises
    ------
    OSError
        If the file cannot be read.
    """
    checksum = 0
    with file.open("rb") as content:
        while piece := content.read(_PIECE):
            checksum = zlib.crc32(piece, checksum)
    return checksum
