"""Draws the pictures in docs/source/pictures anew: all of them, or those that are named.

Not drawn here are plotjuggler.png, lichtblick.png and rqt_plot.png: they show other people's
programs, and were taken by hand. Pictures of pages need chromium; without it they stay as they
are.
"""

import argparse
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from live_pictures import take_live_pictures
from PIL import Image

from bdt_live.measuring.chromium import NAMES, find_chromium

PICTURES = Path(__file__).parent / "source" / "pictures"
BDT = Path(sys.executable).with_name("bdt")
EVALUATION = ("--runs", "16", "--seed", "3000")
"""The runs of the table in explanation/estimators.md."""
COLORS = 128
"""Pages have few colors; a picture of all is three times as large."""


class Drawing:
    """Draws into PICTURES; runs that several pictures need are made once."""

    def __init__(self, folder: Path, browser: str | None) -> None:
        self._folder = folder
        self._browser = browser

    def run_figure(self, configuration: str, duration: int, picture: str) -> None:
        """Copy the figure of a run."""
        shutil.copy(self._run(configuration, duration) / "figure.png", PICTURES / picture)

    def report(self, configuration: str, duration: int, height: int, *look: str) -> None:
        """Take a picture of a report: part of its address, and options of the browser."""
        page = self._run(configuration, duration) / "report.html"
        moment, name, *options = look
        self._photograph(f"{page.as_uri()}{moment}", height, name, *options)

    def comparison(self) -> None:
        """Take a picture of two runs side by side."""
        bags = [self._run(name, 120) / "bag" for name in ("paper", "fixed_dead_zone")]
        page = self._folder / "comparison.html"
        self._bdt(
            "compare", *(bag.relative_to(self._folder) for bag in bags), "--output", page.name
        )
        self._photograph(page.as_uri(), 1480, "comparison.png")

    def choices(self) -> None:
        """Redo the paper with other choices."""
        self._bdt("reproduce", "--output", "reproduction")
        shutil.copy(self._folder / "reproduction" / "choices.png", PICTURES)

    def evaluation(self) -> None:
        """Try the estimators on random scenarios."""
        self._bdt("evaluate", *EVALUATION, "--figure", PICTURES / "evaluation.png")

    def live(self) -> None:
        """Take pictures of `bdt live`, of a loop that runs for a minute."""
        if self._browser is None:
            self._leave_out("live")
            return
        for name in take_live_pictures(PICTURES):
            _keep_few_colors(name)

    def _run(self, configuration: str, duration: int) -> Path:
        output = self._folder / f"{duration}_s" / configuration
        if not output.exists():
            arguments = (
                "--config",
                configuration,
                "--duration",
                duration,
                "--output",
                Path(f"{duration}_s", configuration),
            )
            self._bdt("run", "--processes", "single", *arguments)
        return output

    def _bdt(self, *arguments: object) -> None:
        subprocess.run([BDT, *map(str, arguments)], cwd=self._folder, check=True)

    def _photograph(self, address: str, height: int, name: str, *options: str) -> None:
        if self._browser is None:
            self._leave_out(name)
            return
        subprocess.run(
            [
                self._browser,
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--hide-scrollbars",
                f"--user-data-dir={self._folder / 'browser'}",
                f"--window-size=1120,{height}",
                "--virtual-time-budget=10000",
                f"--screenshot={PICTURES / name}",
                *options,
                address,
            ],
            check=True,
            capture_output=True,
        )
        _keep_few_colors(name)

    def _leave_out(self, name: str) -> None:
        print(f"{name}: not drawn, there is no {' or '.join(NAMES)}")


def _keep_few_colors(name: str) -> None:
    with Image.open(PICTURES / name) as picture:
        few_colors = picture.convert("RGB").quantize(COLORS, dither=Image.Dither.NONE)
    few_colors.save(PICTURES / name, optimize=True)


def main() -> None:
    """Draw the pictures that the command line names, or all."""
    with tempfile.TemporaryDirectory() as folder:
        drawing = Drawing(Path(folder), find_chromium())
        dark = ("--blink-settings=preferredColorScheme=0",)
        steps: dict[str, Callable[[], None]] = {
            "paper_run": lambda: drawing.run_figure("paper", 120, "paper_run.png"),
            "linear_run": lambda: drawing.run_figure("linear", 120, "linear_run.png"),
            "report": lambda: drawing.report("paper", 120, 1330, "", "report.png"),
            "report_dark": lambda: drawing.report(
                "linear", 60, 1500, "#step=6,end", "report_dark.png", *dark
            ),
            "comparison": drawing.comparison,
            "choices": drawing.choices,
            "evaluation": drawing.evaluation,
            "live": drawing.live,
        }
        parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
        parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(steps))
        names = parser.parse_args().names or list(steps)
        for name in names:
            if name not in steps:
                parser.error(f"{name!r}: must be one of {', '.join(steps)}")
        for name in names:
            steps[name]()
            print(f"{name}: drawn", flush=True)


if __name__ == "__main__":
    main()
