"""The server of the page: static files, one socket a page, reports; nothing without the cookie."""

import asyncio
import json
import time
from collections import deque
from collections.abc import Awaitable, Callable
from http import HTTPStatus
from importlib.resources import files
from pathlib import Path

from aiohttp import WSCloseCode, WSMsgType, web

from bdt_live.access import COOKIE, Access
from bdt_live.page_requests import LARGEST_MESSAGE, PageRequestError, read_request
from bdt_live.viewers import Viewer, Viewers

TYPES = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
}
REPORT_TYPES = {".html": "text/html", ".png": "image/png"}

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
    "connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'"
)
REPORT_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src 'self' data: blob:; base-uri 'none'; frame-ancestors 'none'; sandbox allow-scripts"
)
"""A report is one file with its scripts in it, made from a bag: it gets no way to the page."""

HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}

MOST_PAGES = 20
MOST_REQUESTS = 60
"""Requests of a page within a second; a slider that is dragged sends 30."""

PASSWORD_PERIOD = 1.0
"""Wall time [s] between two passwords that are tried, by whomever."""

BEHIND = 10.0
"""Wall time [s] in which a page has to take a message, or is closed."""

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class PageServer:
    """Serves the page.

    Parameters
    ----------
    access : Access
        Who may see it.
    viewers : Viewers
        The pages that are open.
    ask : callable
        Called with the number of a page and a request that was checked; with None for a page that
        has come.
    reports : Path
        Folder of the reports, each in a folder of its own.
    """

    def __init__(
        self,
        access: Access,
        viewers: Viewers,
        ask: Callable[[int, str | None], None],
        reports: Path,
    ) -> None:
        self._access, self._viewers, self._ask, self._reports = access, viewers, ask, reports
        folder = files("bdt_live") / "page"
        self._files = {
            entry.name: entry.read_bytes()
            for entry in folder.iterdir()
            if Path(entry.name).suffix in TYPES
        }
        self._next_password = 0.0

    def application(self) -> web.Application:
        """Return the application that aiohttp runs."""
        application = web.Application(middlewares=[self._guard], client_max_size=LARGEST_MESSAGE)
        application.add_routes(
            [
                web.get("/", self._begin),
                web.post("/login", self._log_in),
                web.get("/socket", self._talk),
                web.get("/page/{name}", self._file),
                web.get("/report/{name}/{file}", self._report),
            ]
        )
        return application

    @web.middleware
    async def _guard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        is_open = request.path in ("/", "/login")
        if not self._access.is_host(request.headers.get("Host")):
            return _refusal("this is not the name of this server")
        if not is_open and not self._is_known(request):
            return _refusal("open the address that `bdt live` has printed")
        try:
            response = await handler(request)
        except web.HTTPException as error:
            response = web.Response(status=error.status, text=f"{error.reason}\n")
        if not response.prepared:
            response.headers.update(HEADERS)
            response.headers.setdefault("Content-Security-Policy", POLICY)
        return response

    def _is_known(self, request: web.Request) -> bool:
        return self._access.is_session(request.cookies.get(COOKIE, ""))

    # Pages ---------------------------------------------------------------------------------

    async def _begin(self, request: web.Request) -> web.StreamResponse:
        token = request.query.get("token")
        if token is not None and self._access.is_token(token):
            if self._access.password is None:
                return self._admission()
            text = self._files["login.html"].decode().replace("TOKEN", self._access.token)
            return web.Response(text=text, content_type="text/html")
        if token is not None or not self._is_known(request):
            return _refusal("open the address that `bdt live` has printed")
        return web.Response(body=self._files["index.html"], content_type="text/html")

    async def _log_in(self, request: web.Request) -> web.StreamResponse:
        now = time.monotonic()
        if now < self._next_password:
            return _refusal("one password a second", HTTPStatus.TOO_MANY_REQUESTS)
        self._next_password = now + PASSWORD_PERIOD
        given = await request.post()
        token, password = (given.get(name) for name in ("token", "password"))
        if not (isinstance(token, str) and isinstance(password, str)):
            return _refusal("needs token and password")
        is_right = self._access.is_token(token) & self._access.is_password(password)
        return self._admission() if is_right else _refusal("this is not the password")

    def _admission(self) -> web.Response:
        response = web.Response(status=HTTPStatus.SEE_OTHER, headers={"Location": "/"})
        response.set_cookie(
            COOKIE, self._access.session, httponly=True, samesite="Strict", path="/"
        )
        return response

    async def _file(self, request: web.Request) -> web.StreamResponse:
        name = request.match_info["name"]
        if name not in self._files:
            return _refusal("no such file", HTTPStatus.NOT_FOUND)
        return web.Response(body=self._files[name], content_type=TYPES[Path(name).suffix])

    async def _report(self, request: web.Request) -> web.StreamResponse:
        # Names are compared with what there is: nothing of a request becomes part of a path.
        for folder in self._reports.iterdir() if self._reports.is_dir() else ():
            for file in folder.iterdir() if folder.name == request.match_info["name"] else ():
                if file.name == request.match_info["file"] and file.suffix in REPORT_TYPES:
                    return web.Response(
                        body=await asyncio.to_thread(file.read_bytes),
                        content_type=REPORT_TYPES[file.suffix],
                        headers={"Content-Security-Policy": REPORT_POLICY},
                    )
        return _refusal("no such report", HTTPStatus.NOT_FOUND)

    # Sockets -------------------------------------------------------------------------------

    async def _talk(self, request: web.Request) -> web.StreamResponse:
        if not self._access.is_origin(request.headers.get("Origin")):
            return _refusal("a socket is for the page of this server")
        if len(self._viewers) >= MOST_PAGES:
            return _refusal("too many pages", HTTPStatus.SERVICE_UNAVAILABLE)
        socket = web.WebSocketResponse(max_msg_size=LARGEST_MESSAGE, heartbeat=20.0)
        await socket.prepare(request)
        viewer = self._viewers.add()
        sending = asyncio.create_task(self._send(socket, viewer))
        try:
            await self._listen(socket, viewer)
        finally:
            self._viewers.remove(viewer)
            sending.cancel()
        return socket

    async def _send(self, socket: web.WebSocketResponse, viewer: Viewer) -> None:
        while True:
            text = await viewer.next()
            if text is None:
                text = self._viewers.history.text()
                self._ask(viewer.number, None)
            try:
                await asyncio.wait_for(socket.send_str(text), BEHIND)
            except (ConnectionError, TimeoutError):
                await socket.close(code=WSCloseCode.TRY_AGAIN_LATER)
                return

    async def _listen(self, socket: web.WebSocketResponse, viewer: Viewer) -> None:
        times: deque[float] = deque([0.0] * MOST_REQUESTS, maxlen=MOST_REQUESTS)
        async for message in socket:
            now = time.monotonic()
            if message.type is not WSMsgType.TEXT or now - times[0] < 1.0:
                await socket.close(code=WSCloseCode.POLICY_VIOLATION)
                return
            times.append(now)
            try:
                read_request(message.data)
            except PageRequestError as error:
                viewer.put(json.dumps({"type": "refused", "reason": str(error)}))
            else:
                self._ask(viewer.number, message.data)


def _refusal(reason: str, status: HTTPStatus = HTTPStatus.FORBIDDEN) -> web.Response:
    headers = {**HEADERS, "Content-Security-Policy": POLICY}
    return web.Response(status=status, text=f"{reason}\n", headers=headers)
