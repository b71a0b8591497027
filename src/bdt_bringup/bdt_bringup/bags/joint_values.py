"""Stamps and values of a JointState topic at once: a run has 60 000 measurements."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_bringup.bags.bag_error import BagError
from bdt_bringup.bags.bag_reader import RawTopic, decode, typestore

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_STAMP = slice(4, 12)
"""Place of the stamp: the first field, after four bytes that tell the encoding (CDR)."""


def joint_values(
    path: Path, raw: RawTopic, read: Callable[[Any], tuple[int, float]], quantity: str
) -> tuple[IntArray, FloatArray]:
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

    Returns
    -------
    stamps : ndarray of int64, shape (k,)
        Stamps [ns] in the order of the bag.
    values : ndarray, shape (k,)
        Values in SI units.

    Raises
    ------
    BagError
        If a message is damaged or cannot be read.
    """
    stamps, values = np.zeros(len(raw.data), np.int64), np.full(len(raw.data), np.nan)
    alike = np.zeros(len(raw.data), np.bool_)
    place = _place_of_value(path, raw, quantity)
    if place is not None:
        first = np.frombuffer(raw.data[0], np.uint8)
        alike = np.array([len(data) for data in raw.data]) == first.size
        rows = np.flatnonzero(alike)
        table = np.frombuffer(b"".join([raw.data[k] for k in rows]), np.uint8)
        table = table.reshape(-1, first.size)
        same = table == first
        same[:, _STAMP] = same[:, place : place + 8] = True
        alike[rows] = same.all(axis=1)
        table = table[alike[rows]]
        parts = np.ascontiguousarray(table[:, _STAMP]).view("<u4").astype(np.int64)
        stamps[alike] = parts[:, 0].astype(np.int32) * np.int64(1_000_000_000) + parts[:, 1]
        values[alike] = np.ascontiguousarray(table[:, place : place + 8]).view("<f8")[:, 0]
    for number in np.flatnonzero(~alike).tolist():
        (message,) = decode(path, replace(raw, data=[raw.data[number]]))
        try:
            stamps[number], values[number] = read(message)
        except ValueError as error:
            raise BagError(f"bag {path}: message {number} of {raw.name}: {error}") from None
    return stamps, values


def _place_of_value(path: Path, raw: RawTopic, quantity: str) -> int | None:
    """Return where the value stands in the bytes of the first message; None if it is not simple.

    It is where the bytes change when the value does.
    """
    (message,) = decode(path, replace(raw, data=raw.data[:1]))
    if len(message.name) != 1 or len(getattr(message, quantity)) != 1:
        return None
    before = typestore().serialize_cdr(message, raw.message_type)
    if bytes(before) != raw.data[0]:
        return None
    changed = replace(
        message, **{quantity: (~getattr(message, quantity).view(np.uint64)).view("f8")}
    )
    after = typestore().serialize_cdr(changed, raw.message_type)
    different = np.flatnonzero(np.frombuffer(before, np.uint8) != np.frombuffer(after, np.uint8))
    return int(different[0]) if different.size == 8 else None
