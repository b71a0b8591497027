"""Values that a message takes for its fields of numbers: arrays of the right type."""

from array import array
from typing import Any

import numpy as np

__all__ = ["to_array", "to_fixed_array"]


def to_fixed_array(code: str, value: Any, size: int) -> "np.ndarray[Any, Any]":
    """Make a numpy array of a size."""
    result = np.array(value, dtype=code)
    assert result.shape == (size,)
    return result


def to_array(code: str, value: Any) -> "array[Any]":
    """Make an ``array.array``; quickly if the value is a numpy array."""
    if isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.char != "O":
        # array.array would walk a numpy array element by element: 40 ns each.
        wanted = np.dtype(code)
        if value.dtype == wanted or np.can_cast(value.dtype, wanted, "safe"):
            result = array(code)
            result.frombytes(np.ascontiguousarray(value, wanted).tobytes())
            return result
    return array(code, value)
