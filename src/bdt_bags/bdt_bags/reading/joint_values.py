"""Stamps and values of a JointState topic at once: a run has 60 000 measurements."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_bags.reading.bag_reader import RawTopic, decode, typestore

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_STAMP = slice(4, 12)
"""Place of the stamp: the first field, after four bytes that tell the encoding (CDR)."""


class JointValues(NamedTuple):
    """Stamps and values of a topic in the order of the bag.

    Attributes
    ----------
    stamps : ndarray of int64, shape (k,)
        Stamps [ns].
    values : ndarray, shape (k,)
        Values in SI units.
    faults : mapping of int to str
        What is wrong with messages that say nothing of the joint, by their number.
    """

    stamps: IntArray
    values: FloatArray
    faults: Mapping[int, str]


def joint_values(
    path: Path, raw: RawTopic, read: Callable[[Any], tuple[int, float]], quantity: str
) -> JointValues:
    """Return stamps and values of all messages.

    Messages of one node differ in stamp and value only. Where they do, both are taken from the
    same bytes of all messages; every other message is decoded by itself.

    Parameters
    ----------
    path : Path
        The bag, for messages.
    raw : RawTopic
        A topic of JointState.
    read : callable
        Returns ``(stamp [ns], value)`` of a message, or raises ValueError.
    quantity : str
        The field of the value: ``position`` or ``effort``.

    Raises
    ------
    BagError
        If a message is damaged.
    """
    stamps, values = np.zeros(len(raw.data), np.int64), np.full(len(raw.data), np.nan)
    alike = np.zeros(len(raw.data), np.bool_)
    faults: dict[int, str] = {}
    for pattern in range(len(raw.data)):
        (message,) = decode(path, raw.one(pattern))
        try:
            stamps[pattern], values[pattern] = read(message)
        except ValueError as error:
            faults[pattern] = str(error)
            continue
        place = _place_of_value(message, raw.data[pattern], raw.message_type, quantity)
        if place is not None:
            alike = _take_alike(raw, pattern, place, stamps, values)
        break
    alike[list(faults)] = True
    for number in np.flatnonzero(~alike).tolist():
        (message,) = decode(path, raw.one(number))
        try:
            stamps[number], values[number] = read(message)
        except ValueError as error:
            faults[number] = str(error)
    return JointValues(stamps, values, faults)


def _take_alike(
    raw: RawTopic, pattern: int, place: int, stamps: IntArray, values: FloatArray
) -> NDArray[np.bool_]:
    """Fill in all messages that differ from one in stamp and value only; return which they are."""
    first = np.frombuffer(raw.data[pattern], np.uint8)
    alike: NDArray[np.bool_] = np.array([len(data) for data in raw.data]) == first.size
    rows = np.flatnonzero(alike)
    table = np.frombuffer(b"".join([raw.data[k] for k in rows]), np.uint8)
    table = table.reshape(-1, first.size)
    same = table == first
    same[:, _STAMP] = same[:, place : place + 8] = True
    alike[rows] = same.all(axis=1)
    table = table[alike[rows]]
    parts = np.ascontiguousarray(table[:, _STAMP]).view("<u4").astype(np.int64)
    # Seconds are signed. numpy 1 would multiply 32 bits by a scalar of 64 in 32.
    stamps[alike] = parts[:, 0].astype(np.int32).astype(np.int64) * 1_000_000_000 + parts[:, 1]
    values[alike] = np.ascontiguousarray(table[:, place : place + 8]).view("<f8")[:, 0]
    return alike


def _place_of_value(message: Any, data: bytes, message_type: str, quantity: str) -> int | None:
    """Return where the value stands in the bytes of a message; None if it is not simple.

    It is where the bytes change when the value does.
    """
    if len(message.name) != 1 or len(getattr(message, quantity)) != 1:
        return None
    before = typestore().serialize_cdr(message, message_type)
    if bytes(before) != data:
        return None
    changed = replace(
        message, **{quantity: (~getattr(message, quantity).view(np.uint64)).view("f8")}
    )
    after = typestore().serialize_cdr(changed, message_type)
    different = np.flatnonzero(np.frombuffer(before, np.uint8) != np.frombuffer(after, np.uint8))
    return int(different[0]) if different.size == 8 else None
