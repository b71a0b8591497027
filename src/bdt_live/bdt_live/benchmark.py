"""``bdt bench live``: what a page costs the loop, and how soon it shows what is dragged."""

import asyncio
import math
import os
import tempfile
import time
from asyncio.subprocess import DEVNULL, Process
from collections.abc import Sequence
from contextlib import AsyncExitStack
from itertools import pairwise
from pathlib import Path
from statistics import median, quantiles
from typing import Any

from bdt_live.measuring.chromium import Chromium
from bdt_live.measuring.drawn_page import picture_rate, time_to_drawing
from bdt_live.measuring.process_load import (
    growth,
    memory_of,
    processor_time_of,
    tree_of,
    words_of,
)
from bdt_live.measuring.running_programs import browsers, line_of, python, server
from bdt_live.measuring.socket_page import socket_pages

PAGES = 3
DRAGS = 60
PERIOD = 1.0
"""Wall time [s] between two looks at the memory."""

LONGEST_LOOK = 20.0
"""Longest wall time [s] for which the pictures of a page are counted."""

BESIDE_OTHERS = 19
"""Niceness of browsers that look on while something else is measured."""

SUSPENDED = 60.0
"""Longest wall time [s] for which a page is suspended."""

FEWEST_ROUNDS, MOST_ROUNDS = 4, 20
"""How often the page comes and goes beside a loop in real time."""

SETTLED = 1.0
"""Wall time [s] that is left out after the page has come or gone."""

ROUND = 9.0
"""Wall time [s] with the page and without it: the speed of a computer changes within minutes."""

MOST_CHANGE = 0.05
"""Share by which a page may change the loop's time."""

MEDIAN_OF_NORMAL = 1.86
"""Standard deviation of the median of normal values, times the root of their number, over their
median deviation from it."""

ROS_PROCESS = "bdt_live.ros_process"


def live(duration: float) -> list[dict[str, Any]]:
    """Run loops with their page, and measure.

    Parameters
    ----------
    duration : float
        Wall time for which three browsers look on [s].

    Returns
    -------
    list of dict
        Fields of a :class:`bdt_study.benchmarks.result.BenchmarkResult` each.

    Raises
    ------
    BadInputError
        If there is no browser.
    """
    return asyncio.run(_measure(duration))


async def _measure(duration: float) -> list[dict[str, Any]]:
    with tempfile.TemporaryDirectory() as folder:
        return [
            *await _beside_its_own_loop(Path(folder) / "live", duration),
            *await _beside_a_loop_in_real_time(Path(folder), duration),
        ]


async def _beside_its_own_loop(folder: Path, duration: float) -> list[dict[str, Any]]:
    async with server(folder) as (address, process):
        async with socket_pages(address, 1) as (page,):
            await asyncio.wait_for(page.ready(), 60.0)
            to_row = [await page.drag(round(0.01 + 0.002 * n, 6)) for n in range(DRAGS)]
        drawn = await _look(address, min(duration, LONGEST_LOOK), to_row)
        watched = await _watch(address, process, duration)
        suspended = min(duration, SUSPENDED)
        late = await _time_to_catch_up(address, suspended)
    what = f"after {suspended:g} s"
    back = _target("suspended_page_is_back", 1e3 * late, "ms", what, "at most", 1000.0)
    return [*drawn, *watched, back]


async def _look(address: str, duration: float, to_row: list[float]) -> list[dict[str, Any]]:
    """Drag in front of a page, and count its pictures; most of the time of a drag is to a row."""
    async with browsers(address, 1) as (browser,):
        drags = [await asyncio.to_thread(time_to_drawing, browser, turn) for turn in range(DRAGS)]
        rate = await asyncio.to_thread(picture_rate, browser, duration)
    shares = f"{DRAGS} drags; a row has it after {1e3 * _p95(to_row):.0f} ms"
    return [
        _target("slider_to_drawing_p95", 1e3 * _p95(drags), "ms", shares, "at most", 150.0),
        _target("animation", rate, "1/s", f"all plots on, {duration:g} s", "at least", 30.0),
    ]


def _p95(values: list[float]) -> float:
    return quantiles(values, n=20)[-1]


async def _watch(address: str, process: int, duration: float) -> list[dict[str, Any]]:
    """Let three browsers look on, and a page that counts what comes."""
    async with (
        browsers(address, PAGES, BESIDE_OTHERS) as opened,
        socket_pages(address, 1) as (page,),
    ):
        memory: dict[str, list[int]] = {}
        begun, begin = processor_time_of(process), time.monotonic()
        looking = asyncio.create_task(page.look_on(duration))
        while not looking.done():
            # In a thread: it takes tenths of a second, in which a page would fall behind.
            await asyncio.to_thread(_note_memory, memory, process, opened)
            await asyncio.wait([looking], timeout=PERIOD)
        await looking
        elapsed = time.monotonic() - begin
        share = (processor_time_of(process) - begun) / elapsed
    what = f"with {len(opened)} browsers, {duration:g} s"
    return [
        _target("frames_of_a_page", page.frames / elapsed, "1/s", what, "at least", 30.0),
        _target("server", 100.0 * share, "% of a core", what, "at most", 15.0),
        *(
            _target(
                f"memory of {name}",
                100.0 * growth(samples),
                "%",
                f"growth from {median(samples) / 2**20:.0f} MiB, 2nd to last quarter",
                "at most",
                5.0,
            )
            for name, samples in memory.items()
        ),
    ]


def _note_memory(memory: dict[str, list[int]], server: int, opened: Sequence[Chromium]) -> None:
    processes = {"server": [server], "ROS process": _ros_processes(server)}
    processes |= {f"browser {n}": tree_of(each.process) for n, each in enumerate(opened, 1)}
    for name, each in processes.items():
        memory.setdefault(name, []).append(memory_of(each))


def _ros_processes(server: int) -> list[int]:
    return [each for each in tree_of(server) if ROS_PROCESS in words_of(each)]


async def _time_to_catch_up(address: str, duration: float) -> float:
    """Suspend a page, and return how long after it goes on it shows what is [s]."""
    async with socket_pages(address, 2) as (suspended, other):
        await suspended.next()
        await other.look_on(duration)
        now = 0.0
        while now == 0.0:
            message = await other.next()
            now = message["rows"][-1][0] if message["type"] == "frame" else 0.0
        begin = time.monotonic()
        try:
            await suspended.see(now)
        except TypeError:  # closed, for it has taken nothing for long: a page then opens another
            async with socket_pages(address, 1) as (again,):
                await again.see(now)
        return time.monotonic() - begin


# Beside a loop that does not wait --------------------------------------------------------------


async def _beside_a_loop_in_real_time(folder: Path, duration: float) -> list[dict[str, Any]]:
    """Let the page come and go beside a loop, and compare each time with before and after."""
    rounds = min(max(round(duration / (2.0 * ROUND)), FEWEST_ROUNDS), MOST_ROUNDS)
    length = min(max(duration / rounds, SETTLED + 2.0), ROUND)
    place = ["--namespace", f"benchmark_{os.getpid()}"]
    run = ["run", "--mode", "realtime", "--no-bag", "--duration", "1e6", *place]
    run += ["--output", str(folder / "run")]
    ros = ["--ros-args", "-r", f"__ns:=/benchmark_{os.getpid()}"]
    async with AsyncExitStack() as stack:
        quiet = {"stdout": DEVNULL, "stderr": DEVNULL}  # that it was interrupted is no news
        await stack.enter_async_context(python("-m", "bdt_bringup.program", *run, **quiet))
        observer = await stack.enter_async_context(
            python("-m", "bdt_live.measuring.loop_observer", *ros)
        )
        await line_of(observer)
        alone, with_page = [await _latency(observer, length)], []
        for number in range(rounds):
            output = folder / f"attached-{number}"
            async with (
                server(output, "--attach", *place) as (address, _),
                socket_pages(address, PAGES) as pages,
            ):
                await asyncio.gather(*(page.see(0.0) for page in pages))
                looking = [asyncio.create_task(page.look_on(length)) for page in pages]
                with_page.append(await _latency(observer, length))
                await asyncio.gather(*looking)
            alone.append(await _latency(observer, length))
    beside = zip(with_page, pairwise(alone), strict=True)
    changes = [2.0 * there / (before + after) - 1.0 for there, (before, after) in beside]
    change = median(changes)
    spread = median(abs(each - change) for each in changes)
    uncertainty = MEDIAN_OF_NORMAL * spread / math.sqrt(rounds)
    what = f"± {100.0 * uncertainty:.1f} %, {rounds} times, {1e6 * median(alone):.0f} µs without"
    # No page can be told from none by less than twice the uncertainty.
    allowed = 100.0 * max(MOST_CHANGE, 2.0 * uncertainty)
    return [_target("latency_change", 100.0 * change, "%", what, "at most", allowed)]


async def _latency(observer: Process, duration: float) -> float:
    """Return the median of what the observer tells in a time, once the loop has settled [s]."""
    begin, told = time.monotonic(), []
    while (elapsed := time.monotonic() - begin) < duration:
        line = await line_of(observer)
        if elapsed > SETTLED:
            told.append(float(line))
    return median(told)


def _target(
    name: str, value: float, unit: str, reference: str, target: str, limit: float
) -> dict[str, Any]:
    return {
        "name": f"live: {name}",
        "value": value,
        "unit": unit,
        "reference": reference,
        "reference_value": limit,
        "ratio": value / limit,
        "target": target,
    }
