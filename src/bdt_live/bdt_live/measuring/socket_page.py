"""A page as the server sees one: a socket that takes what comes and asks for something."""

import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import aiohttp

from bdt_live.extremes import COLUMNS

GAP = COLUMNS.index("gap")


class SocketPage:
    """A page without a browser.

    Parameters
    ----------
    socket : aiohttp.ClientWebSocketResponse
        To the server.

    Attributes
    ----------
    frames : int
        Frames that have come.
    """

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self._socket = socket
        self._number = 0
        self.frames = 0

    async def next(self) -> dict[str, Any]:
        """Return the next message."""
        message: dict[str, Any] = await self._socket.receive_json(timeout=30.0)
        self.frames += message["type"] == "frame"
        return message

    async def look_on(self, duration: float) -> None:
        """Take what comes for a time [s]."""
        end = time.monotonic() + duration
        while time.monotonic() < end:
            await self.next()

    async def ready(self) -> None:
        """Wait until the plant can be asked."""
        while True:
            message = await self.next()
            if (
                message["type"] == "parameters"
                and message["node"] == "plant"
                and message["controls"]
            ):
                return

    async def drag(self, gap: float) -> float:
        """Set the gap [rad] and return the time until a row shows it [s]."""
        self._number += 1
        values = {"gap.kind": "constant", "gap.initial": gap}
        request = {"number": self._number, "action": "set", "node": "plant", "values": values}
        begin = time.monotonic()
        await self._socket.send_json(request)
        while True:
            message = await self.next()
            rows = message["rows"] if message["type"] == "frame" else []
            if any(row[GAP] is not None and abs(row[GAP] - gap) < 1e-9 for row in rows):
                return time.monotonic() - begin

    async def see(self, time_shown: float) -> None:
        """Take what comes until a row of a time [s] is there."""
        while True:
            message = await self.next()
            frames = [message] if message["type"] == "frame" else message.get("frames", [])
            if frames and frames[-1]["rows"][-1][0] >= time_shown:
                return


@asynccontextmanager
async def socket_pages(address: str, count: int) -> AsyncIterator[list[SocketPage]]:
    """Open some pages at the address that ``bdt live`` has printed."""
    base = address.split("/?", maxsplit=1)[0]
    jar = aiohttp.CookieJar(unsafe=True)
    async with aiohttp.ClientSession(cookie_jar=jar) as session:
        async with session.get(address):
            pass
        sockets = [
            await session.ws_connect(f"{base}/socket", headers={"Origin": base}, max_msg_size=0)
            for _ in range(count)
        ]
        yield [SocketPage(socket) for socket in sockets]
        for socket in sockets:
            await socket.close()
