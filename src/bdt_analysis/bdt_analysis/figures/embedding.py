"""Data and library of the interactive plots as text that a page carries along."""

import base64
import gzip
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray


def packed_text(data: bytes) -> str:
    """Return bytes as text for a page: gzip (the same for the same bytes), then base64."""
    return base64.b64encode(gzip.compress(data, 9, mtime=0)).decode("ascii")


def packed_arrays(arrays: Iterable[NDArray[np.float64]]) -> bytes:
    """Return arrays one after the other as 32-bit floats, the bytes of equal weight together.

    Neighboring samples share their high bytes, so that gzip finds them: the signals of a run take
    half of the room.

    Parameters
    ----------
    arrays : iterable of ndarray, shape (n,)
        The arrays. Their relative precision becomes 6e-8.

    Returns
    -------
    bytes
        For each array its n lowest bytes, then the n next ones up to the highest.
    """
    planes = []
    for array in arrays:
        with np.errstate(over="ignore"):  # a position that ran away ends the line
            numbers = np.ascontiguousarray(array, dtype="<f4")
        planes.append(numbers.view(np.uint8).reshape(-1, 4).T.tobytes())
    return b"".join(planes)
