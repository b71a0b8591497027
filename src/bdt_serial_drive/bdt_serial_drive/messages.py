"""Messages of the serial protocol: what the payloads of its frames hold, little-endian."""

import struct
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_serial_drive.frames import LONGEST_PAYLOAD

PROTOCOL_VERSION = 1
VOLTAGE_UNIT = 1e-6
"""Unit of voltages on the line [V]."""
POSITION_UNIT = 1e-9
"""Unit of positions on the line [m]."""
LARGEST = 2**31 - 1
"""Largest number of units on the line, of either sign."""
SAMPLE_NUMBERS = 2**32
"""Sample numbers begin anew after so many."""

_BEGIN = struct.Struct("<H")
_VOLTAGE = struct.Struct("<i")
_IDENTITY = struct.Struct("<BIiH")
_SAMPLES = struct.Struct("<IB")
_ROW = np.dtype([("voltage", "<i4"), ("position", "<i4")])
LARGEST_COUNT = (LONGEST_PAYLOAD - _SAMPLES.size) // _ROW.itemsize
"""Largest number of samples in one message."""


class Kind(IntEnum):
    """Kinds of messages; those of the device have the highest bit set."""

    BEGIN = 0x01
    VOLTAGE = 0x02
    STOP = 0x03
    END = 0x04
    IDENTITY = 0x81
    SAMPLES = 0x82


class Identity(NamedTuple):
    """What a device says of itself when a computer begins.

    Attributes
    ----------
    version : int
        Version of the protocol, :data:`PROTOCOL_VERSION`.
    sampling_rate : float
        Samples per second by the device's clock [Hz], in steps of 1 mHz.
    voltage_limit : float
        Largest voltage of either sign that the motor gets [V].
    watchdog : float
        Time without a voltage message after which the motor gets none [s], in steps of 1 ms.
    """

    version: int
    sampling_rate: float
    voltage_limit: float
    watchdog: float


class Samples(NamedTuple):
    """Samples in a row.

    Attributes
    ----------
    first : int
        Number of the first one, modulo :data:`SAMPLE_NUMBERS`.
    is_silent : bool
        Whether the device has taken the voltage off because no voltage message came.
    rows : ndarray, shape (n, 2)
        Voltage applied from the sample on [V], and position [m].
    """

    first: int
    is_silent: bool
    rows: NDArray[np.float64]


def begin_payload(watchdog: float) -> bytes:
    """Return the payload of ``BEGIN``: the watchdog's time [s]."""
    return _BEGIN.pack(round(watchdog * 1e3))


def read_begin(payload: bytes) -> float | None:
    """Return the watchdog's time [s]; None if the payload is none of ``BEGIN``."""
    return _BEGIN.unpack(payload)[0] * 1e-3 if len(payload) == _BEGIN.size else None


def voltage_payload(voltage: float) -> bytes:
    """Return the payload of ``VOLTAGE``.

    Parameters
    ----------
    voltage : float
        Motor voltage [V].

    Raises
    ------
    ValueError
        If it is no finite number that the line can carry.
    """
    largest = LARGEST * VOLTAGE_UNIT
    if not abs(voltage) <= largest:
        raise ValueError(f"voltage = {voltage!r} V: must be a number within {largest:g} V")
    return _VOLTAGE.pack(round(voltage / VOLTAGE_UNIT))


def read_voltage(payload: bytes) -> float | None:
    """Return the voltage [V]; None if the payload is none of ``VOLTAGE``."""
    return _VOLTAGE.unpack(payload)[0] * VOLTAGE_UNIT if len(payload) == _VOLTAGE.size else None


def identity_payload(identity: Identity) -> bytes:
    """Return the payload of ``IDENTITY``."""
    return _IDENTITY.pack(
        identity.version,
        round(identity.sampling_rate * 1e3),
        round(identity.voltage_limit / VOLTAGE_UNIT),
        round(identity.watchdog * 1e3),
    )


def read_identity(payload: bytes) -> Identity | None:
    """Return what a device says of itself; None if the payload is none of ``IDENTITY``."""
    if len(payload) != _IDENTITY.size:
        return None
    version, rate, limit, watchdog = _IDENTITY.unpack(payload)
    return Identity(version, rate * 1e-3, limit * VOLTAGE_UNIT, watchdog * 1e-3)


def samples_payload(samples: Samples) -> bytes:
    """Return the payload of ``SAMPLES``; at most :data:`LARGEST_COUNT` rows."""
    rows = np.empty(len(samples.rows), _ROW)
    for column, unit, values in zip(
        ("voltage", "position"), (VOLTAGE_UNIT, POSITION_UNIT), samples.rows.T, strict=True
    ):
        rows[column] = np.rint(values / unit).clip(-LARGEST, LARGEST)
    head = _SAMPLES.pack(samples.first % SAMPLE_NUMBERS, samples.is_silent)
    return head + rows.tobytes()


def read_samples(payload: bytes) -> Samples | None:
    """Return samples; None if the payload is none of ``SAMPLES``."""
    content = len(payload) - _SAMPLES.size
    if content <= 0 or content % _ROW.itemsize:
        return None
    first, flags = _SAMPLES.unpack_from(payload)
    found = np.frombuffer(payload, _ROW, offset=_SAMPLES.size)
    rows = np.column_stack((found["voltage"] * VOLTAGE_UNIT, found["position"] * POSITION_UNIT))
    return Samples(first, bool(flags & 1), rows)
