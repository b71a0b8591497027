"""Runs `bdt live`: the loop, the process behind the page, the server, the reports of bags."""

import asyncio
import json
import os
import signal
import socket
import subprocess
import sys
import webbrowser
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from aiohttp import web

from bdt_bringup.installed import installed_commands
from bdt_bringup.run_plan import RunPlan
from bdt_bringup.supervisor import Supervisor, describe_end
from bdt_live.access import Access
from bdt_live.channel import Channel, channel_pair
from bdt_live.from_server import page_asks, page_has_come
from bdt_live.niceness import REPORT_NICENESS, let_others_go_first
from bdt_live.server import PageServer
from bdt_live.viewers import Viewers
from bdt_msgs_py.command_errors import BadInputError, LoopError
from bdt_msgs_py.folder_sync import create_folder
from bdt_msgs_py.process_end import ProcessEnd

LOOK = 0.2
"""Wall time [s] between two looks at the processes."""


@dataclass(frozen=True)
class LiveSettings:
    """What `bdt live` shows, and to whom.

    Attributes
    ----------
    module : str
        Module of the process behind the page.
    arguments : tuple of str
        What follows the number of its socket and `output`.
    output : Path
        Folder for logs, bags and reports.
    plan : RunPlan or None
        The loop to start; None for one that runs, or a bag.
    open_browser : bool
        Whether to open the page in a browser.
    """

    module: str
    arguments: Sequence[str]
    output: Path
    plan: RunPlan | None = None
    open_browser: bool = False


def run_live(settings: LiveSettings, access: Access) -> int:
    """Serve the page until Ctrl-C or SIGTERM.

    Parameters
    ----------
    settings : LiveSettings
        What to show.
    access : Access
        Where, and to whom; with port 0 any port that is free.

    Returns
    -------
    int
        0.

    Raises
    ------
    BadInputError
        If the port is taken, or the folder cannot be written.
    LoopError
        If the process behind the page has ended.
    """
    # A port that is taken is refused before anything is started for it.
    with _listening(access) as listening:
        access = replace(access, port=listening.getsockname()[1])
        create_folder(settings.output)
        supervisor = Supervisor(settings.plan) if settings.plan else None
        try:
            if supervisor:
                supervisor.start_all()
            asyncio.run(_Session(settings, access, supervisor).run(listening))
        finally:
            if supervisor:
                supervisor.stop()
    return 0


class _Session:
    """The server with what stands behind it."""

    def __init__(
        self, settings: LiveSettings, access: Access, supervisor: Supervisor | None
    ) -> None:
        self._settings, self._access, self._supervisor = settings, access, supervisor
        self._viewers = Viewers()
        own, other = channel_pair()
        self._channel = Channel(own)
        self._process = _start(settings, other.fileno())
        other.close()
        self._end = ProcessEnd(self._process)
        self._reporting: set[asyncio.Task[None]] = set()
        self._fault = ""

    async def run(self, listening: socket.socket) -> None:
        stopped = asyncio.Event()
        loop = asyncio.get_running_loop()
        for number in (signal.SIGINT, signal.SIGTERM):
            loop.add_signal_handler(number, stopped.set)
        loop.add_reader(self._channel.fileno(), self._take_messages)
        server = PageServer(self._access, self._viewers, self._ask, self._reports)
        runner = web.AppRunner(server.application(), access_log=None, shutdown_timeout=1.0)
        await runner.setup()
        try:
            await web.SockSite(runner, listening).start()
            await self._tell_address()
            while not stopped.is_set():
                self._look()
                try:
                    await asyncio.wait_for(stopped.wait(), LOOK)
                except TimeoutError:
                    continue
        finally:
            loop.remove_reader(self._channel.fileno())
            await runner.cleanup()
            self._end.ask()
            self._end.wait()
            self._channel.close()

    @property
    def _reports(self) -> Path:
        return self._settings.output / "reports"

    async def _tell_address(self) -> None:
        print(f"{self._access.address}\nCtrl-C ends it", flush=True)
        if self._settings.open_browser:
            await asyncio.to_thread(webbrowser.open, self._access.address)

    def _look(self) -> None:
        self._channel.flush()
        if self._process.poll() is not None:
            raise LoopError(f"the process behind the page ended with {self._process.returncode}")
        if self._supervisor is None or self._fault:
            return
        try:
            self._supervisor.look()
        except (LoopError, BadInputError) as error:
            self._fault = str(error)
        if (machine := self._supervisor.machine).exit_code is not None:
            self._fault = describe_end(machine)
        if self._fault:
            # The page stays: whoever looks wants to know why, and may save the last minute.
            print(f"error: {self._fault}", file=sys.stderr, flush=True)
            self._viewers.tell(json.dumps({"type": "fault", "text": self._fault}))

    def _ask(self, page: int, text: str | None) -> None:
        self._channel.send(page_has_come() if text is None else page_asks(page, text))
        if text is None and self._fault:
            self._viewers.tell(json.dumps({"type": "fault", "text": self._fault}), page)

    def _take_messages(self) -> None:
        for text in self._channel.receive() or ():
            # What kind it is stands at the beginning; most go on as they are.
            if text.startswith('{"type":"frame"'):
                begin = float(text[text.index("[[") + 2 : text.index(",", text.index("[["))])
                self._viewers.history.add(begin, text)
                self._viewers.tell(text)
            elif text.startswith('{"type":"reply"'):
                self._viewers.tell(text, json.loads(text)["page"])
            else:
                self._viewers.tell(text)
                if text.startswith('{"type":"saved"'):
                    self._report_on(json.loads(text))

    # Reports -------------------------------------------------------------------------------

    def _report_on(self, saved: dict[str, str | None]) -> None:
        if saved["reason"] is None and "analyze" in installed_commands():
            task = asyncio.create_task(self._analyze(str(saved["bag"])))
            self._reporting.add(task)
            task.add_done_callback(self._reporting.discard)

    async def _analyze(self, bag: str) -> None:
        folder = self._settings.output / bag
        command = ["-m", "bdt_bringup.cli", "analyze", str(folder)]
        process = await asyncio.create_subprocess_exec(
            sys.executable,
            *command,
            "--output",
            str(self._reports / bag),
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.DEVNULL,
            stderr=asyncio.subprocess.PIPE,
        )
        let_others_go_first(process.pid, REPORT_NICENESS)
        try:
            _, said = await process.communicate()
        except asyncio.CancelledError:
            process.kill()
            raise
        reason = None if process.returncode == 0 else said.decode(errors="replace").strip()[-300:]
        self._viewers.tell(json.dumps({"type": "report", "bag": bag, "reason": reason}))


def _listening(access: Access) -> socket.socket:
    family = socket.AF_INET6 if ":" in access.host else socket.AF_INET
    try:
        return socket.create_server((access.host, access.port), family=family)
    except OSError as error:
        raise BadInputError(
            f"--port {access.port}: cannot listen on {access.host}: {error.strerror}"
        ) from error


def _start(settings: LiveSettings, number: int) -> subprocess.Popen[bytes]:
    guard = ["-m", "bdt_bringup.child_node", str(os.getpid()), settings.module]
    arguments = [str(number), str(settings.output), *settings.arguments]
    return subprocess.Popen(  # noqa: S603
        [sys.executable, *guard, *arguments],
        pass_fds=(number,),
        stdin=subprocess.DEVNULL,
        start_new_session=True,
    )


def live_plan(plan: RunPlan) -> RunPlan:
    """Return a plan as a loop that somebody looks at needs it: at the pace of the wall clock."""
    if plan.is_real:
        return plan
    plant = {
        "pace": 1.0,
        "telemetry_period": 0.02,
        "lockstep_followers": [""],
        "lockstep_timeout": 60.0,
    }
    return replace(plan, plant=plant)
