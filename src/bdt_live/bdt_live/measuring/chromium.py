"""A browser without a window that does what it is told: Chromium over its debugging pipe."""

import base64
import contextlib
import json
import os
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path
from queue import Empty, Queue
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

DEADLINE = 180.0
"""Wall time [s] after which a condition counts as never met."""

END = 60.0
"""Wall time [s] in which a browser has to end."""

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

OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--remote-debugging-pipe",
)


class ChromiumError(RuntimeError):
    """The browser, or the page in it, does not do what it is told."""


def find_chromium() -> str | None:
    """Return the browser that is on the PATH; None without one."""
    return next((found for found in map(shutil.which, NAMES) if found), None)


class Chromium:
    """A browser with one page, told by JSON messages, each ended by a zero byte, what to do.

    Parameters
    ----------
    binary : str
        The program, as :func:`find_chromium` finds it.
    profile : Path
        Folder for what it keeps.
    niceness : int
        How much it lets others go first, 0 to 19.

    Attributes
    ----------
    process : int
        The process that has started all others of the browser.
    events : list of dict
        What the browser has told unasked.
    """

    def __init__(self, binary: str, profile: Path, niceness: int = 0) -> None:
        commands, self._to_browser = os.pipe()
        self._from_browser, answers = os.pipe()
        connect = [sys.executable, "-c", CONNECT, str(commands), str(answers), binary, *OPTIONS]
        self._browser = subprocess.Popen(  # noqa: S603
            [*connect, f"--user-data-dir={profile}", "about:blank"],
            pass_fds=(commands, answers),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self.process = self._browser.pid
        os.setpriority(os.PRIO_PROCESS, self.process, niceness)
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
        self.command("Page.enable")

    def watch(self) -> None:
        """Let the browser tell what it complains about and asks for, and each message of a socket.

        This is work for both, so that whoever measures does without.
        """
        for domain in ("Runtime", "Network", "Log"):
            self.command(f"{domain}.enable")

    def _read(self) -> None:
        data = b""
        while chunk := os.read(self._from_browser, 1 << 16):
            *whole, data = (data + chunk).split(b"\0")
            for text in whole:
                self._messages.put(json.loads(text))

    def command(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command and return its result; events that come meanwhile are kept.

        Raises
        ------
        ChromiumError
            If the browser refuses it, or does not answer.
        """
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
                raise ChromiumError(f"no answer to {method} within {DEADLINE:g} s") from None
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise ChromiumError(f"{method}: {answer['error']}")
                result: dict[str, Any] = answer["result"]
                return result
            if "method" in answer:
                self.events.append(answer)

    def evaluate(self, expression: str) -> Any:
        """Return the value of a JavaScript expression; a promise is awaited.

        Raises
        ------
        ChromiumError
            If the expression throws.
        """
        answer = self.command(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        if "exceptionDetails" in answer:
            raise ChromiumError(f"{expression}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def wait_for(self, expression: str, deadline: float = DEADLINE) -> None:
        """Wait until an expression is true, as often as the page paints.

        Raises
        ------
        ChromiumError
            If it is not within a wall time of `deadline` [s].
        """
        end = time.monotonic() + deadline
        painted = "new Promise((done) => requestAnimationFrame(done))"
        while not self.evaluate(expression):
            if time.monotonic() > end:
                raise ChromiumError(f"not within {deadline:g} s: {expression}")
            self.evaluate(f"Promise.race([{painted}, new Promise((d) => setTimeout(d, 50))])")

    def resize(self, width: int, height: int) -> None:
        """Give the page a size [px]; a narrow one is a phone's."""
        self.command(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=width < 600,
        )

    def prefer(self, scheme: str) -> None:
        """Prefer pages that are ``dark``, or ``light``."""
        feature = {"name": "prefers-color-scheme", "value": scheme}
        self.command("Emulation.setEmulatedMedia", media="screen", features=[feature])

    def go(self, address: str) -> None:
        """Begin to load a page."""
        self.command("Page.navigate", url=address)

    def picture(self) -> bytes:
        """Return a picture of what is seen of the page, as PNG."""
        return base64.b64decode(self.command("Page.captureScreenshot", format="png")["data"])

    def close(self) -> None:
        """End the browser."""
        os.close(self._to_browser)
        try:
            self._browser.wait(timeout=END)
        except subprocess.TimeoutExpired:
            self._browser.kill()
            self._browser.wait()
        self._reader.join(timeout=END)
        with contextlib.suppress(OSError):
            os.close(self._from_browser)
