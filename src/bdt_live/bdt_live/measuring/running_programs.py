"""The programs that ``bdt bench live`` looks at: loops, servers, browsers."""

import asyncio
import os
import shutil
import signal
import sys
import tempfile
from asyncio.subprocess import DEVNULL, PIPE, Process
from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path

from bdt_live.measuring.process_load import connections_to

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
START = 60.0
"""Wall time [s] in which a program has to be there."""


def environment() -> dict[str, str]:
    """Return the environment of a loop: on this computer, in a ROS domain of this process."""
    own = {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_DOMAIN_ID": str(1 + os.getpid() % 100),
    }
    return own | os.environ


@asynccontextmanager
async def python(*arguments: str, stdout: int = PIPE) -> AsyncIterator[Process]:
    """Run Python with some arguments, and end it as Ctrl-C does."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, *arguments, env=environment(), stdin=DEVNULL, stdout=stdout
    )
    try:
        yield process
    finally:
        if process.returncode is None:
            process.send_signal(signal.SIGINT)
        # What it still says must not keep it from ending.
        await process.communicate()


@asynccontextmanager
async def server(folder: Path, *arguments: str) -> AsyncIterator[tuple[str, int]]:
    """Run ``bdt live``; give its address and its process."""
    options = ["--port", "0", "--output", str(folder)]
    async with python("-m", "bdt_bringup.program", "live", *options, *arguments) as process:
        yield await line_of(process), process.pid


async def line_of(process: Process) -> str:
    """Return the next line that a process prints.

    Raises
    ------
    RuntimeError
        If it prints none within ``START``.
    """
    if process.stdout is None:
        raise RuntimeError("the program has no standard output")
    line = await asyncio.wait_for(process.stdout.readline(), START)
    if not line:
        raise RuntimeError("the program has ended without a word")
    return line.decode().strip()


@asynccontextmanager
async def browsers(address: str, count: int) -> AsyncIterator[Sequence[int]]:
    """Open the page in browsers without a window; give their processes, none without a browser."""
    binary = next((found for found in map(shutil.which, BROWSERS) if found), None)
    port = int(address.partition("/?")[0].rpartition(":")[2])
    async with AsyncExitStack() as stack:
        processes = []
        for _ in range(count if binary else 0):
            # A browser that ends still writes into its profile.
            profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
            stack.enter_context(profile)
            processes.append(await stack.enter_async_context(_browser(binary, profile, address)))
        end = asyncio.get_running_loop().time() + START
        while connections_to(port) < len(processes):
            if asyncio.get_running_loop().time() > end:
                raise RuntimeError(f"no {len(processes)} pages are open within {START:g} s")
            await asyncio.sleep(0.2)
        yield [process.pid for process in processes]


@asynccontextmanager
async def _browser(
    binary: str | None, profile: "tempfile.TemporaryDirectory[str]", address: str
) -> AsyncIterator[Process]:
    options = ["--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={profile.name}"]
    process = await asyncio.create_subprocess_exec(
        str(binary), *options, address, stdin=DEVNULL, stdout=DEVNULL, stderr=DEVNULL
    )
    os.setpriority(os.PRIO_PROCESS, process.pid, 19)
    try:
        yield process
    finally:
        process.terminate()
        await process.wait()
