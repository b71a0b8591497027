"""``bdt bench live``: what a page costs the loop, and how soon it shows what is dragged."""

import asyncio
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from statistics import median, quantiles
from typing import Any

import aiohttp

from bdt_live.extremes import COLUMNS

PAGES = 3
DRAGS = 60
WATCH = 60.0
"""Wall time [s] for which three pages look on."""

REFERENCE_WATCH = 20.0
"""Wall time [s] for which nobody looks on, before and after."""

SUSPENDED = 60.0
"""Wall time [s] for which a page is suspended."""

GAP = COLUMNS.index("gap")


class Page:
    """A page as the server sees one: a socket that takes what comes.

    Parameters
    ----------
    socket : aiohttp.ClientWebSocketResponse
        To the server.
    """

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self._socket = socket
        self._number = 0
        self.latencies: list[float] = []
        self.frames = 0

    async def next(self) -> dict[str, Any]:
        """Return the next message."""
        message: dict[str, Any] = await self._socket.receive_json(timeout=30.0)
        self.frames += message["type"] == "frame"
        if message["type"] == "state" and message["latency"] is not None:
            self.latencies.append(message["latency"])
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


def live() -> list[dict[str, Any]]:
    """Run a loop with its page, and measure.

    Returns
    -------
    list of dict
        Fields of a :class:`bdt_study.benchmarks.result.BenchmarkResult` each.
    """
    return asyncio.run(_measure())


async def _measure() -> list[dict[str, Any]]:
    with tempfile.TemporaryDirectory() as folder:
        async with _program(Path(folder) / "live") as (address, server):
            async with _pages(address, 1) as (first,):
                await asyncio.wait_for(first.ready(), 60.0)
                drags = [await first.drag(round(0.01 + 0.002 * n, 6)) for n in range(DRAGS)]
            alone = await _latencies(address, REFERENCE_WATCH)
            memory, begun, begin = _memory(server), _processor_time(server), time.monotonic()
            async with _pages(address, PAGES) as pages:
                await asyncio.gather(*(page.look_on(WATCH) for page in pages))
                elapsed = time.monotonic() - begin
                share = (_processor_time(server) - begun) / elapsed
                grown = _memory(server) - memory
                watched = median(pages[0].latencies)
                frames = min(page.frames for page in pages) / elapsed
            alone += await _latencies(address, REFERENCE_WATCH)
            late = await _time_to_catch_up(address)
    change = watched / median(alone) - 1.0
    return [
        _result("slider_to_row_p95", 1e3 * quantiles(drags, n=20)[-1], "ms", "at most", 110.0),
        _result("frames_each_page", frames, "1/s", "at least", 30.0),
        _result("server_with_3_pages", 100.0 * share, "% of a core", "at most", 15.0),
        _result("server_memory_growth", grown / 2**20, "MiB", f"in {WATCH:g} s", None),
        _result("latency_change", 100.0 * change, "%", "three pages beside one; below", 5.0),
        _result("suspended_page_is_back", 1e3 * late, "ms", "at most", 1000.0),
    ]


def _result(
    name: str, value: float, unit: str, reference: str, limit: float | None
) -> dict[str, Any]:
    ratio = None if limit is None else value / limit
    return {
        "name": f"live: {name}",
        "value": value,
        "unit": unit,
        "reference": reference,
        "reference_value": limit,
        "ratio": ratio,
    }


@asynccontextmanager
async def _program(output: Path) -> AsyncIterator[tuple[str, int]]:
    """Run `bdt live` in a namespace of its own; give address and process."""
    port = 20_000 + os.getpid() % 20_000
    place = ["--namespace", f"benchmark_{os.getpid()}", "--output", str(output)]
    command = ["-m", "bdt_bringup.program", "live", "--port", str(port), *place]
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        *command,
        env={"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", **os.environ},
        stdout=subprocess.PIPE,
    )
    try:
        if process.stdout is None:
            raise RuntimeError("bdt live has no standard output")
        line = await asyncio.wait_for(process.stdout.readline(), 60.0)
        yield line.decode().strip(), process.pid
    finally:
        process.send_signal(signal.SIGINT)
        await process.wait()


@asynccontextmanager
async def _pages(address: str, count: int) -> AsyncIterator[list[Page]]:
    base = address.split("/?", maxsplit=1)[0]
    jar = aiohttp.CookieJar(unsafe=True)
    async with aiohttp.ClientSession(cookie_jar=jar) as session:
        async with session.get(address):
            pass
        sockets = [
            await session.ws_connect(f"{base}/socket", headers={"Origin": base}, max_msg_size=0)
            for _ in range(count)
        ]
        yield [Page(socket) for socket in sockets]
        for socket in sockets:
            await socket.close()


async def _latencies(address: str, duration: float) -> list[float]:
    """Return the loop's latencies [s] in a time in which one page looks on."""
    async with _pages(address, 1) as (page,):
        await page.look_on(duration)
        return page.latencies


async def _time_to_catch_up(address: str) -> float:
    """Suspend a page, and return how long after it goes on it shows what is [s]."""
    async with _pages(address, 2) as (suspended, other):
        await suspended.next()
        await other.look_on(SUSPENDED)
        now = 0.0
        while now == 0.0:
            message = await other.next()
            now = message["rows"][-1][0] if message["type"] == "frame" else 0.0
        begin = time.monotonic()
        try:
            await _see(suspended, now)
        except TypeError:  # closed, for it has taken nothing for long: a page then opens another
            async with _pages(address, 1) as (again,):
                await _see(again, now)
        return time.monotonic() - begin


async def _see(page: Page, now: float) -> None:
    """Take what comes until a row of a time [s] is there."""
    while True:
        message = await page.next()
        frames = [message] if message["type"] == "frame" else message.get("frames", [])
        if frames and frames[-1]["rows"][-1][0] >= now:
            return


def _processor_time(process: int) -> float:
    """Return user and system time of a process [s]."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _memory(process: int) -> int:
    """Return the memory that a process has resident [byte]."""
    found = re.search(r"VmRSS:\s+(\d+) kB", Path(f"/proc/{process}/status").read_text())
    return int(found[1]) * 1024 if found else 0
