"""A real browser for the pages, with no other software than Chromium."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from bdt_live.measuring.chromium import NAMES, Chromium, find_chromium


class Browser(Chromium):
    """Chromium for pages on disk, and its mouse and its complaints."""

    def open(
        self, page: Path, fragment: str = "", *, width: int = 1200, scheme: str = "light"
    ) -> None:
        """Open a page from disk and wait for its plots."""
        self.resize(width, 1000)
        self.prefer(scheme)
        self.go("about:blank")
        self.wait_for("location.href === 'about:blank'")
        self.events.clear()
        self.go(page.as_uri() + fragment)
        self.wait_for("!!document.documentElement && 'plots' in document.documentElement.dataset")

    def drag(self, begin: tuple[float, float], end: tuple[float, float]) -> None:
        """Drag with the left button."""
        for kind, (x, y), buttons in (
            ("mouseMoved", begin, 0),
            ("mousePressed", begin, 1),
            ("mouseMoved", end, 1),
            ("mouseReleased", end, 0),
        ):
            button = "none" if kind == "mouseMoved" and not buttons else "left"
            self.command(
                "Input.dispatchMouseEvent",
                type=kind,
                x=x,
                y=y,
                button=button,
                buttons=buttons,
                clickCount=1,
            )

    def complaints(self) -> list[str]:
        """Return errors and warnings of the page, and requests for anything but the page."""
        found = []
        for event in self.events:
            parameters = event["params"]
            if event["method"] == "Runtime.exceptionThrown":
                found.append(str(parameters["exceptionDetails"]))
            elif event["method"] == "Runtime.consoleAPICalled":
                if parameters["type"] in {"error", "warning"}:
                    found.append(str(parameters["args"]))
            elif event["method"] == "Log.entryAdded":
                found.append(str(parameters["entry"]))
            elif event["method"] == "Network.requestWillBeSent":
                url = parameters["request"]["url"]
                if not url.startswith(("file:", "data:", "blob:")):
                    found.append(url)
        return found


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """Return one browser for all tests."""
    binary = find_chromium()
    if binary is None:
        pytest.skip(f"needs a browser: none of {', '.join(NAMES)} is on the PATH")
    opened = Browser(binary, tmp_path_factory.mktemp("profile"))
    opened.watch()
    yield opened
    opened.close()
