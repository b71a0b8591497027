"""Frames on a serial line: from messages to bytes, and from any bytes back to what is intact.

A frame is two start bytes, the length of the payload, the kind of message, a sequence number, the
payload, and a CRC-16. The page *Serial protocol* of the reference has it byte by byte.
"""

import struct
from binascii import crc_hqx
from typing import NamedTuple

START = b"\xb5\x62"
"""Bytes with which every frame begins."""
HEADER = struct.Struct("<2sBBB")
CHECKSUM = struct.Struct("<H")
LONGEST_PAYLOAD = 255
"""Largest number of bytes that a payload has."""
LONGEST_FRAME = HEADER.size + LONGEST_PAYLOAD + CHECKSUM.size
"""Largest number of bytes that a frame has."""
FIRST_CHECKSUM = 0xFFFF


class Frame(NamedTuple):
    """What a frame carries.

    Attributes
    ----------
    kind : int
        Kind of message, 0 to 255.
    sequence : int
        Number of the frame by its sender, modulo 256.
    payload : bytes
        Content.
    """

    kind: int
    sequence: int
    payload: bytes


def encoded(frame: Frame) -> bytes:
    """Return the bytes of a frame.

    Raises
    ------
    ValueError
        If the payload is longer than :data:`LONGEST_PAYLOAD`.
    """
    if len(frame.payload) > LONGEST_PAYLOAD:
        raise ValueError(
            f"payload of {len(frame.payload)} bytes: must be at most {LONGEST_PAYLOAD}"
        )
    header = HEADER.pack(START, len(frame.payload), frame.kind, frame.sequence % 256)
    return header + frame.payload + CHECKSUM.pack(checksum(header[len(START) :] + frame.payload))


def checksum(content: bytes) -> int:
    """Return the CRC-16 of length, kind, sequence number and payload.

    Polynomial 0x1021, first value 0xFFFF, no reflection, no final inversion: the one that is known
    as CRC-16/CCITT-FALSE and CRC-16/IBM-3740.
    """
    return crc_hqx(content, FIRST_CHECKSUM)


class FrameReader:
    """Finds the intact frames in what a line delivers.

    After bytes that are no frame it begins anew one byte behind their start, so that every intact
    frame is found, whatever came before it.

    Attributes
    ----------
    skipped : int
        Number of bytes so far that belong to no intact frame.
    """

    def __init__(self) -> None:
        self._waiting = bytearray()
        self.skipped = 0

    def feed(self, received: bytes) -> list[Frame]:
        """Return the frames that are complete with these bytes, oldest first.

        Parameters
        ----------
        received : bytes
            What the line has delivered since the call before; may begin and end anywhere.
        """
        self._waiting += received
        frames: list[Frame] = []
        position = 0
        while (begin := self._waiting.find(START, position)) >= 0:
            self.skipped += begin - position
            position = begin
            length = self._length(begin)
            if length is None:
                break
            frame = self._intact(begin, length)
            if frame is None:
                position += 1
                self.skipped += 1
            else:
                frames.append(frame)
                position += length
        else:
            # The last byte may be the first of the next frame.
            rest = len(self._waiting) - self._waiting.endswith(START[:1])
            self.skipped += max(rest - position, 0)
            position = max(rest, position)
        del self._waiting[:position]
        return frames

    def _length(self, begin: int) -> int | None:
        """Return how long the frame that begins here is; None while it is not complete."""
        available = len(self._waiting) - begin
        if available < HEADER.size:
            return None
        length = HEADER.size + self._waiting[begin + len(START)] + CHECKSUM.size
        return length if available >= length else None

    def _intact(self, begin: int, length: int) -> Frame | None:
        frame = bytes(self._waiting[begin : begin + length])
        (found,) = CHECKSUM.unpack_from(frame, length - CHECKSUM.size)
        if checksum(frame[len(START) : -CHECKSUM.size]) != found:
            return None
        _, _, kind, sequence = HEADER.unpack_from(frame)
        return Frame(kind, sequence, frame[HEADER.size : -CHECKSUM.size])
