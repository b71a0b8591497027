"""Messages between the process of the page and the process of ROS, neither of which ever waits."""

import json
import socket
from collections import deque
from typing import Any

LONGEST = 1 << 17
"""Bytes of a message."""

MOST_WAITING = 200
"""Messages that wait for the other side; of more, the oldest frames are dropped."""


class Channel:
    """One end of a pair of sockets that keep messages apart.

    Parameters
    ----------
    end : socket.socket
        From :func:`channel_pair`; closed by :meth:`close`.

    Attributes
    ----------
    dropped : int
        Number of frames that the other side was too slow for.
    """

    def __init__(self, end: socket.socket) -> None:
        end.setblocking(False)
        self._socket = end
        self._waiting: deque[tuple[bool, bytes]] = deque()
        self.dropped = 0

    def fileno(self) -> int:
        """Return the number of the socket, for those who wait until something comes."""
        return self._socket.fileno()

    def send(self, message: dict[str, Any], *, may_be_dropped: bool = False) -> None:
        """Send a message, or keep it until the other side takes it.

        Parameters
        ----------
        message : dict
            Anything that JSON can hold.
        may_be_dropped : bool
            Whether it is a frame: the next one says nearly the same.
        """
        data = json.dumps(message, separators=(",", ":"), allow_nan=False).encode()
        if len(data) > LONGEST:
            raise ValueError(f"a message of {len(data)} bytes: must be {LONGEST} at most")
        self._waiting.append((may_be_dropped, data))
        self.flush()

    def flush(self) -> None:
        """Send what has waited, as far as the other side takes it."""
        while self._waiting:
            try:
                self._socket.send(self._waiting[0][1])
            except BlockingIOError:
                self._drop_frames()
                return
            except (BrokenPipeError, ConnectionResetError):
                self._waiting.clear()  # nobody is there any more; `receive` tells it
                return
            self._waiting.popleft()

    def receive(self) -> list[str] | None:
        """Return the messages that have come; None when the other side is gone."""
        messages: list[str] = []
        while True:
            try:
                data = self._socket.recv(LONGEST)
            except BlockingIOError:
                return messages
            except ConnectionResetError:
                return None
            if not data:
                return messages or None
            messages.append(data.decode())

    def close(self) -> None:
        """Close this end."""
        self._socket.close()

    def _drop_frames(self) -> None:
        excess = len(self._waiting) - MOST_WAITING
        for entry in [entry for entry in self._waiting if entry[0]][: max(excess, 0)]:
            self._waiting.remove(entry)
            self.dropped += 1


def channel_pair() -> tuple[socket.socket, socket.socket]:
    """Return two sockets: what is sent into one comes out of the other, message by message."""
    return socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
