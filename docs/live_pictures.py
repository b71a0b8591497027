"""Takes the pictures of `bdt live`: a loop that runs, a page in Chromium, and what a user does."""

import asyncio
import tempfile
from pathlib import Path

from bdt_live.measuring.chromium import Chromium
from bdt_live.measuring.running_programs import browsers, server

WALL = (1600, 1000)
PHONE = (375, 812)
GAP = 15.0
"""Gap of the pictures [°]: without a dead zone the loop is in a limit cycle."""

STEP = 10.0
"""Time between two steps of the reference [s]."""

LATE = 0.6
"""Share of a step after which a loop that comes to rest has done so."""


class Photographer:
    """Does on a page what the tutorial says, and takes pictures of it.

    Parameters
    ----------
    browser : Chromium
        With the page.
    folder : Path
        Folder of the pictures.
    """

    def __init__(self, browser: Chromium, folder: Path) -> None:
        self._browser, self._folder = browser, folder
        self.taken: list[str] = []

    def take_all(self) -> None:
        """Take all pictures: a limit cycle, the twin at work in the dark, in the light, narrow."""
        self._use_theme("dark")
        self._browser.wait_for("document.getElementById('state').dataset.word === 'ok'")
        self._wait_for_end_of_step(0)
        self._choose("linear")
        self._wait_for_end_of_step(1)
        self._take("live_limit_cycle.png")
        self._click("mark")
        self._choose("paper")
        self._wait_for_end_of_step(2)
        self._take("live.png")
        self._use_theme("light")
        self._take("live_light.png")
        self._take("live_phone.png", PHONE)

    def _choose(self, preset: str) -> None:
        """Choose a figure of the paper, and a gap for it."""
        begin = "document.getElementById('plant.gap.begin_time').value"
        before = self._browser.evaluate(begin)
        self._browser.evaluate(f"document.querySelector('[data-preset={preset}]').click()")
        # The plant is the last node that gets values of a preset.
        self._browser.wait_for(f"{begin} !== '{before}'")
        self._browser.evaluate(
            "(() => { const gap = document.getElementById('plant.gap.initial');"
            f"gap.value = {GAP}; gap.dispatchEvent(new Event('change')); }})()"
        )

    def _use_theme(self, theme: str) -> None:
        if self._browser.evaluate("document.documentElement.dataset.theme") != theme:
            self._click("theme")

    def _click(self, name: str) -> None:
        self._browser.evaluate(f"document.getElementById('{name}').click()")

    def _wait_for_end_of_step(self, steps: int) -> None:
        time = "parseFloat(document.getElementById('time').textContent)"
        number = int(self._browser.evaluate(time) // STEP) + steps
        self._browser.wait_for(f"{time} > {(number + LATE) * STEP}")

    def _take(self, name: str, size: tuple[int, int] = WALL) -> None:
        self._browser.resize(*size)
        frames = "Number(document.documentElement.dataset.frames)"
        # All four plots in the new size and theme: one of them is drawn in each frame.
        self._browser.wait_for(f"{frames} > {self._browser.evaluate(frames) + 8}")
        (self._folder / name).write_bytes(self._browser.picture())
        self.taken.append(name)


def take_live_pictures(pictures: Path) -> list[str]:
    """Take all pictures of the page, and return their names.

    Raises
    ------
    BadInputError
        If there is no browser.
    """
    return asyncio.run(_take_pictures(pictures))


async def _take_pictures(pictures: Path) -> list[str]:
    with tempfile.TemporaryDirectory() as folder:
        async with (
            server(Path(folder) / "live") as (address, _),
            browsers(address, 1) as (browser,),
        ):
            photographer = Photographer(browser, pictures)
            await asyncio.to_thread(photographer.take_all)
            return photographer.taken
