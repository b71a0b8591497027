"""The programs that ``bdt bench live`` looks at: loops, servers, browsers."""

import asyncio
import os
import signal
import sys
import tempfile
from asyncio.subprocess import DEVNULL, PIPE, Process
from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path

from bdt_live.measuring.chromium import NAMES, Chromium, find_chromium
from bdt_msgs_py.command_errors import BadInputError

SCREEN = (1920, 1080)
IS_THERE = "document.getElementById('plant.gap.initial') !== null"
"""Whether a page has the sliders of a plant."""

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
async def python(
    *arguments: str, stdout: int = PIPE, stderr: int | None = None
) -> AsyncIterator[Process]:
    """Run Python with some arguments, and end it as Ctrl-C does."""
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        *arguments,
        env=environment(),
        stdin=DEVNULL,
        stdout=stdout,
        stderr=stderr,
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
async def browsers(
    address: str, count: int, niceness: int = 0
) -> AsyncIterator[Sequence[Chromium]]:
    """Open the page in browsers without a window, of the size of a screen on the wall.

    Raises
    ------
    BadInputError
        If there is no browser.
    """
    binary = find_chromium()
    if binary is None:
        raise BadInputError(f"needs a browser: none of {', '.join(NAMES)} is on the PATH")
    async with AsyncExitStack() as stack:
        opened = []
        for _ in range(count):
            # A browser that ends still writes into its profile.
            profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
            folder = Path(stack.enter_context(profile))
            browser = await asyncio.to_thread(Chromium, binary, folder, niceness)
            stack.push_async_callback(asyncio.to_thread, browser.close)
            browser.resize(*SCREEN)
            browser.go(address)
            opened.append(browser)
        for browser in opened:
            await asyncio.to_thread(browser.wait_for, IS_THERE, START)
        yield opened
