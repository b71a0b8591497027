"""A real browser for the pages: headless Chromium over its debugging pipe, no other software."""

import contextlib
import json
import os
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from queue import Empty, Queue
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
DEADLINE = 180.0
"""Wall time [s] after which a condition counts as never met."""

CONNECT = """
import os, sys
source, target = (os.dup(int(number)) for number in sys.argv[1:3])
os.dup2(source, 3)
os.dup2(target, 4)
for number in (3, 4):
    os.set_inheritable(number, True)  # dup2 leaves a number that is already right as it is
os.execv(sys.argv[3], sys.argv[3:])
"""
"""Starts Chromium, which reads from 3 and writes to 4, with the two ends of the pipes there."""


class Browser:
    """Chromium that is told by JSON messages, each ended by a zero byte, what to do."""

    def __init__(self, binary: str, profile: Path) -> None:
        commands, self._to_browser = os.pipe()
        self._from_browser, answers = os.pipe()
        self._process = subprocess.Popen(
            [
                sys.executable,
                "-c",
                CONNECT,
                str(commands),
                str(answers),
                binary,
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--disable-dev-shm-usage",
                "--remote-debugging-pipe",
                f"--user-data-dir={profile}",
                "--window-size=1200,1000",
                "about:blank",
            ],
            pass_fds=(commands, answers),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(commands)
        os.close(answers)
        self._messages: Queue[dict[str, Any]] = Queue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self._number = 0
        self._session: str | None = None
        self.events: list[dict[str, Any]] = []
        targets = self.command("Target.getTargets")["targetInfos"]
        page = next(target for target in targets if target["type"] == "page")
        attached = self.command("Target.attachToTarget", targetId=page["targetId"], flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.command(f"{domain}.enable")

    def _read(self) -> None:
        data = b""
        while chunk := os.read(self._from_browser, 1 << 16):
            *whole, data = (data + chunk).split(b"\0")
            for text in whole:
                self._messages.put(json.loads(text))

    def command(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command and return its result; events that come meanwhile are kept."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self._to_browser, data) :]
        end = time.monotonic() + DEADLINE
        while True:
            try:
                answer = self._messages.get(timeout=max(end - time.monotonic(), 0.01))
            except Empty:
                raise AssertionError(f"no answer to {method} within {DEADLINE} s") from None
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return answer["result"]
            if "method" in answer:
                self.events.append(answer)

    def evaluate(self, expression: str) -> Any:
        """Return the value of a JavaScript expression; a promise is awaited."""
        answer = self.command(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def wait_for(self, expression: str) -> None:
        """Wait until an expression is true, as often as the page paints."""
        end = time.monotonic() + DEADLINE
        painted = "new Promise((done) => requestAnimationFrame(done))"
        while not self.evaluate(expression):
            assert time.monotonic() < end, f"not within {DEADLINE} s: {expression}"
            self.evaluate(f"Promise.race([{painted}, new Promise((d) => setTimeout(d, 50))])")

    def open(
        self, page: Path, fragment: str = "", *, width: int = 1200, scheme: str = "light"
    ) -> None:
        """Open a page from disk and wait for its plots."""
        self.command(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=1000,
            deviceScaleFactor=1,
            mobile=False,
        )
        feature = {"name": "prefers-color-scheme", "value": scheme}
        self.command("Emulation.setEmulatedMedia", media="screen", features=[feature])
        self.command("Page.navigate", url="about:blank")
        self.wait_for("location.href === 'about:blank'")
        self.events.clear()
        self.command("Page.navigate", url=page.as_uri() + fragment)
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

    def close(self) -> None:
        """End the browser."""
        os.close(self._to_browser)
        try:
            self._process.wait(timeout=60)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._reader.join(timeout=60)
        with contextlib.suppress(OSError):
            os.close(self._from_browser)


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """Return one browser for all tests."""
    binary = next((found for name in NAMES if (found := shutil.which(name))), None)
    if binary is None:
        pytest.skip(f"needs a browser: none of {', '.join(NAMES)} is on the PATH")
    opened = Browser(binary, tmp_path_factory.mktemp("profile"))
    yield opened
    opened.close()
