"""A loop with its page in a browser, one for the tests of a file: starting either takes seconds."""

import os
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from queue import Empty, Queue
from typing import Any
from urllib.parse import urlsplit

import pytest

from bdt_live.measuring.process_load import words_of

DEADLINE = 120.0
"""Wall time [s] after which a condition counts as never met."""

KEEP_SOCKETS = """
window.sockets = [];
window.WebSocket = class extends WebSocket {
  constructor(...given) {
    super(...given);
    window.sockets.push(this);
  }
};
"""
"""Run before the page, so that a test can break the connection."""


class LiveProgram:
    """`bdt live` as a process.

    Attributes
    ----------
    address : str
        What it has printed.
    output : Path
        Its folder.
    domain, port : int
        Its ROS domain and its port.
    """

    def __init__(
        self,
        output: Path,
        *arguments: str,
        domain: int,
        port: int = 0,
        is_awaited: bool = True,
    ) -> None:
        self.output, self.domain = output, domain
        self._environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
        command = [sys.executable, "-m", "bdt_bringup.program", "live", "--output", str(output)]
        command += ["--port", str(port)]
        self.process = subprocess.Popen(
            [*command, *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=self._environment,
        )
        if is_awaited:
            self._await_address()

    def _await_address(self) -> None:
        lines: Queue[str] = Queue()

        def read() -> None:
            for line in self.process.stdout:
                lines.put(line.strip())

        threading.Thread(target=read, daemon=True).start()
        try:
            self.address = lines.get(timeout=DEADLINE)
            self.port = urlsplit(self.address).port
        except Empty:
            self.end()
            raise AssertionError(f"no address within {DEADLINE} s") from None

    def ros2(self, *arguments: str) -> None:
        """Run ``ros2`` beside the loop; it leaves no daemon behind."""
        ros2 = shutil.which("ros2", path=f"{Path(sys.executable).parent}:{os.environ['PATH']}")
        command = [ros2, *arguments, "--no-daemon"]
        subprocess.run(command, env=self._environment, check=True, capture_output=True)

    def processes(self, module: str) -> list[int]:
        """Return the nodes that run a module."""
        children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children")
        return [each for each in map(int, children.read_text().split()) if module in words_of(each)]

    def end(self) -> str:
        """End the program as Ctrl-C does, and return what it has complained about."""
        self.process.send_signal(signal.SIGINT)
        self.process.wait(timeout=DEADLINE)
        return self.process.stderr.read()


@pytest.fixture(scope="module")
def live_loop(tmp_path_factory: pytest.TempPathFactory, claim_domain: Any) -> Iterator[LiveProgram]:
    """Return a loop of the paper's figure 7 that runs for all tests of a file."""
    output = tmp_path_factory.mktemp("live") / "output"
    program = LiveProgram(output, domain=claim_domain())
    yield program
    complaints = [line for line in program.end().splitlines() if "is started anew" not in line]
    assert complaints == []
    assert program.process.returncode == 0


@pytest.fixture
def beside(tmp_path: Path) -> Iterator[Callable[..., LiveProgram]]:
    """Return a function that starts another one with some arguments."""
    programs: list[LiveProgram] = []

    def start(*arguments: str, **options: Any) -> LiveProgram:
        programs.append(LiveProgram(tmp_path / f"output-{len(programs)}", *arguments, **options))
        return programs[-1]

    yield start
    for program in programs:
        if program.process.poll() is None:
            program.end()


@pytest.fixture(scope="module")
def page(browser: Any, live_loop: LiveProgram) -> Iterator[Any]:
    """Return the browser with the page of the loop, once the loop moves."""
    browser.events.clear()
    browser.resize(1500, 950)
    kept = browser.command("Page.addScriptToEvaluateOnNewDocument", source=KEEP_SOCKETS)
    browser.go(live_loop.address)
    browser.wait_for("document.getElementById('state')?.dataset.word === 'ok'")
    browser.wait_for("document.getElementById('twin.reconfigure') !== null")
    browser.wait_for("document.getElementById('plant.gap.initial') !== null")
    # The page is told that all is well before it has drawn a picture.
    browser.wait_for("parseFloat(document.getElementById('time').textContent) >= 0")
    yield browser
    browser.command("Page.removeScriptToEvaluateOnNewDocument", **kept)
    # Or it would draw until the last test of all files.
    browser.go("about:blank")
