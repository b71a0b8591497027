"""Decompresses what is whole of a damaged frame."""

import contextlib
from io import BytesIO

import lz4.frame
import zstandard

LARGEST_CHUNK = 1 << 30
"""What claims to be larger than this when decompressed is taken for damaged [byte]."""
_PIECE = 1 << 16


def decompressed_zstd(data: bytes, limit: int) -> bytes:
    """Return what a zstd frame holds, up to a limit [byte] and up to where it is damaged."""
    content = bytearray()
    # What comes before the damage is good; the caller compares length and checksum.
    with (
        zstandard.ZstdDecompressor().stream_reader(BytesIO(data)) as reader,
        contextlib.suppress(zstandard.ZstdError),
    ):
        while len(content) < limit and (piece := reader.read(min(_PIECE, limit - len(content)))):
            content += piece
    return bytes(content)


def decompressed_lz4(data: bytes, limit: int) -> bytes:
    """Return what an lz4 frame holds, up to a limit [byte] and up to where it is damaged."""
    decompressor = lz4.frame.LZ4FrameDecompressor()
    content = bytearray()
    # lz4 raises RuntimeError for a damaged frame; the rest is as for zstd.
    with contextlib.suppress(RuntimeError):
        while len(content) < limit and not decompressor.eof:
            piece = decompressor.decompress(data, max_length=min(_PIECE, limit - len(content)))
            data = b""
            if not piece and decompressor.needs_input:
                break
            content += piece
    return bytes(content)
