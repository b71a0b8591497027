"""Finds what a file says it holds but never reached the disk: sectors of zeros."""

import mmap

SECTOR = 512
"""Smallest piece that a disk or a file system writes or leaves [byte]."""


def first_lost_sector(data: bytes | mmap.mmap, begin: int, end: int) -> int:
    """Return where in a part of a file the first sector lies that holds nothing but zeros.

    Parameters
    ----------
    data : bytes or mmap
        The file.
    begin, end : int
        The part; a sector counts that lies in it with a single byte.

    Returns
    -------
    int
        Begin of the sector, or of the part if that comes later; `end` for none.
    """
    for place in range(begin - begin % SECTOR, end, SECTOR):
        if not any(data[place : place + SECTOR]):
            return max(begin, place)
    return end
