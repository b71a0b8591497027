"""Compressed data, decompressed in bounded memory: no size that a file declares is believed."""

import sys
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import IO, Any

import lz4.frame

from bdt_bags.bag_error import BagError, one_line

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"

ALWAYS_ALLOWED = 2**28
"""Size [bytes] that anything may decompress to, however small it is."""

LARGEST_COMPRESSION_RATIO = 200
"""Ratio of decompressed to compressed size from which on something larger is taken for a trap.

Recordings of the loop reach 2 to 10."""

LARGEST_DECOMPRESSED_SIZE = 2**34
"""Size [bytes] that nothing may decompress to."""

PIECE = 2**20

DAMAGED_COMPRESSION = (zstd.ZstdError, RuntimeError, EOFError, ValueError, OSError)
"""What damaged data raises: zstd its own error, lz4 RuntimeError, both EOFError when it is cut
off; a damaged lz4 header makes ValueError and OSError possible."""


def allowed_size(compressed_size: int) -> int:
    """Return how many bytes may come out of `compressed_size` bytes."""
    return min(
        LARGEST_DECOMPRESSED_SIZE, max(ALWAYS_ALLOWED, LARGEST_COMPRESSION_RATIO * compressed_size)
    )


def decompress(data: bytes, compression: str, limit: int) -> bytes:
    """Return the content of compressed data of one or more frames.

    Parameters
    ----------
    data : bytes
        Compressed data.
    compression : str
        ``zstd`` or ``lz4``.
    limit : int
        Largest size of the result [bytes].

    Raises
    ------
    BagError
        If it is damaged or decompresses to more.
    """
    return b"".join(_pieces(BytesIO(data), compression, limit))


def decompress_message(data: bytes, limit: int) -> bytes:
    """Return the content of one zstd frame; a bag may have a hundred thousand of them.

    Parameters
    ----------
    data : bytes
        Compressed data.
    limit : int
        Largest size of the result [bytes].

    Raises
    ------
    BagError
        If it is damaged, decompresses to more or is followed by something else.
    """
    frame = zstd.ZstdDecompressor()
    try:
        # With a limit, the output grows with what comes out, whatever size the frame declares.
        content = frame.decompress(data, limit + 1)
    except DAMAGED_COMPRESSION as error:
        raise BagError(f"zstd data is damaged: {one_line(error)}") from None
    if len(content) > limit:
        raise _too_large("zstd", limit)
    if not frame.eof or frame.unused_data:
        raise BagError("zstd data is damaged: must be one whole frame")
    return content


def decompressed_size(data: bytes, compression: str, limit: int) -> int:
    """Return the size [bytes] of the content without holding it.

    Parameters
    ----------
    data : bytes
        Compressed data.
    compression : str
        ``zstd`` or ``lz4``.
    limit : int
        Largest size allowed [bytes].

    Raises
    ------
    BagError
        If it is damaged or decompresses to more.
    """
    return sum(len(piece) for piece in _pieces(BytesIO(data), compression, limit))


def decompress_file(source: Path, target: Path) -> None:
    """Write the content of a zstd file to another file.

    Raises
    ------
    BagError
        If it is damaged or decompresses to more than :func:`allowed_size`.
    """
    with source.open("rb") as compressed, target.open("wb") as file:
        for piece in _pieces(compressed, "zstd", allowed_size(source.stat().st_size)):
            file.write(piece)


def _pieces(compressed: IO[bytes], compression: str, limit: int) -> Iterator[bytes]:
    # The readers check at the end of each frame that its declared size was true.
    size = 0
    with _open(compressed, compression) as content:
        while True:
            try:
                piece: bytes = content.read(PIECE)
            except DAMAGED_COMPRESSION as error:
                raise BagError(f"{compression} data is damaged: {one_line(error)}") from None
            if not piece:
                return
            size += len(piece)
            if size > limit:
                raise _too_large(compression, limit)
            yield piece


def _open(compressed: IO[bytes], compression: str) -> Any:
    return zstd.open(compressed) if compression == "zstd" else lz4.frame.open(compressed)


def _too_large(compression: str, limit: int) -> BagError:
    return BagError(f"{compression} data expands to more than {limit} bytes: must not")
