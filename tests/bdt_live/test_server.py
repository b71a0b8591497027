"""The server: what it gives to whom, and hostile input to each endpoint."""

import asyncio
import json
from contextlib import asynccontextmanager

import aiohttp
import pytest
from aiohttp import web
from yarl import URL

from bdt_live.access import COOKIE, Access
from bdt_live.page_requests import LARGEST_MESSAGE
from bdt_live.server import MOST_REQUESTS, PageServer
from bdt_live.viewers import Viewers


class Stand:
    """A server with what it was asked, and a client."""

    def __init__(self, session, access, viewers, asked):
        self.session, self.access, self.viewers, self.asked = session, access, viewers, asked
        self.base = f"http://127.0.0.1:{access.port}"
        self.cookies = {COOKIE: access.session}

    async def get(self, path, *, known=True, **options):
        cookies = self.cookies if known else {}
        options = {"cookies": cookies, "allow_redirects": False, **options}
        # A path that is sent as it is written, dots and all.
        url = URL(self.base + path, encoded=True)
        async with self.session.get(url, **options) as response:
            return response.status, await response.read(), response.headers

    def socket(self, *, origin=None, known=True):
        headers = {"Origin": self.base if origin is None else origin}
        if known:
            headers["Cookie"] = f"{COOKIE}={self.access.session}"
        return self.session.ws_connect(f"{self.base}/socket", headers=headers)


@asynccontextmanager
async def standing(reports, password=None):
    site_port = asyncio.get_running_loop().create_server
    server = await site_port(asyncio.Protocol, "127.0.0.1", 0)
    port = server.sockets[0].getsockname()[1]
    server.close()
    await server.wait_closed()
    access, viewers, asked = Access("127.0.0.1", port, password), Viewers(), []
    page_server = PageServer(access, viewers, lambda *what: asked.append(what), reports)
    runner = web.AppRunner(page_server.application())
    await runner.setup()
    await web.TCPSite(runner, "127.0.0.1", port).start()
    jar = aiohttp.DummyCookieJar()
    async with aiohttp.ClientSession(cookie_jar=jar) as session:
        yield Stand(session, access, viewers, asked)
    await runner.cleanup()


@pytest.fixture
def tell(tmp_path):
    """Return a function that runs a story with a stand."""

    def run(story, password=None):
        async def begin():
            async with standing(tmp_path / "reports", password) as stand:
                return await story(stand)

        return asyncio.run(begin())

    return run


def test_the_token_is_exchanged_for_a_cookie_that_no_script_and_no_other_site_gets(tell):
    async def story(stand):
        return await stand.get(f"/?token={stand.access.token}", known=False), stand.access

    (status, _, headers), access = tell(story)
    assert (status, headers["Location"]) == (303, "/")
    cookie = headers["Set-Cookie"]
    assert cookie.startswith(f"{COOKIE}={access.session};")
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie


def test_with_the_cookie_there_is_a_page_that_loads_nothing_from_elsewhere(tell):
    status, body, headers = tell(lambda stand: stand.get("/"))
    assert status == 200
    assert b"<!doctype html>" in body
    assert b"http" not in body
    assert headers["Content-Security-Policy"].startswith("default-src 'none'; script-src 'self';")
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Cache-Control"] == "no-store"


@pytest.mark.parametrize(
    "path",
    ["/", "/?token=", "/?token=x", "/page/main.js", "/socket", "/report/a/report.html", "/none"],
)
def test_without_the_cookie_there_is_nothing(tell, path):
    status, body, _ = tell(lambda stand: stand.get(path, known=False))
    assert status == 403
    assert body == b"open the address that `bdt live` has printed\n"


def test_under_a_name_that_points_here_there_is_nothing_even_with_the_cookie(tell):
    headers = {"Host": "evil.example"}
    assert tell(lambda stand: stand.get("/", headers=headers))[0] == 403


HOSTILE = (
    "../server.py",
    "..%2fserver.py",
    "%2e%2e/server.py",
    "%00",
    "main.js%00.png",
    "a" * 5000,
)


@pytest.mark.parametrize("name", HOSTILE, ids=range(len(HOSTILE)))
def test_no_name_leads_out_of_the_page_s_folder(tell, name):
    for path in (f"/page/{name}", f"/report/{name}/report.html", f"/report/bag/{name}"):
        assert tell(lambda stand, path=path: stand.get(path))[0] in {400, 404}


def test_reports_are_what_lies_in_their_folder_and_get_no_way_to_the_page(tell, tmp_path):
    folder = tmp_path / "reports" / "bag-1"
    folder.mkdir(parents=True)
    (folder / "report.html").write_text("<p>report</p>")
    (folder / "summary.json").write_text("{}")
    (tmp_path / "secret.html").write_text("secret")
    status, body, headers = tell(lambda stand: stand.get("/report/bag-1/report.html"))
    assert (status, body) == (200, b"<p>report</p>")
    assert "sandbox" in headers["Content-Security-Policy"]
    assert tell(lambda stand: stand.get("/report/bag-1/summary.json"))[0] == 404
    assert tell(lambda stand: stand.get("/report/bag-1/..%2f..%2fsecret.html"))[0] == 404


def test_other_methods_are_refused(tell):
    async def story(stand):
        found = set()
        for method in ("PUT", "DELETE", "POST", "PATCH", "TRACE"):
            async with stand.session.request(
                method, f"{stand.base}/", cookies=stand.cookies
            ) as got:
                found.add(got.status)
        return found

    assert tell(story) == {405}


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "", "http://127.0.0.1:1"])
def test_a_socket_is_for_the_page_of_this_server(tell, origin):
    async def story(stand):
        with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
            await stand.socket(origin=origin)
        return refused.value.status

    assert tell(story) == 403


def test_a_socket_needs_the_cookie(tell):
    async def story(stand):
        with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
            await stand.socket(known=False)
        return refused.value.status, stand.asked

    assert tell(story) == (403, [])


def test_a_page_gets_the_history_then_what_comes_and_its_requests_are_passed_on(tell):
    request = '{"number": 1, "action": "pause"}'

    async def story(stand):
        stand.viewers.history.add(0.0, '{"type":"frame"}')
        async with stand.socket() as socket:
            first = await socket.receive_json()
            stand.viewers.tell('{"type":"frame","n":1}')
            second = await socket.receive_json()
            await socket.send_str(request)
            while len(stand.asked) < 2:
                await asyncio.sleep(0)
            return first, second, stand.asked

    first, second, asked = tell(story)
    assert first == {"type": "history", "frames": [{"type": "frame"}]}
    assert second == {"type": "frame", "n": 1}
    assert asked == [(1, None), (1, request)]


def test_a_message_that_is_no_request_is_refused_and_goes_no_further(tell):
    async def story(stand):
        async with stand.socket() as socket:
            await socket.receive()
            await socket.send_str('{"number": 1, "action": "rm -rf"}')
            return await socket.receive_json(), stand.asked

    answer, asked = tell(story)
    assert answer == {"type": "refused", "reason": "action: is not known"}
    assert asked == [(1, None)]


@pytest.mark.parametrize("hostile", ["large", "binary", "many"])
def test_a_socket_that_misbehaves_is_closed(tell, hostile):
    async def story(stand):
        async with stand.socket() as socket:
            await socket.receive()
            if hostile == "large":
                await socket.send_str("x" * (LARGEST_MESSAGE + 1))
            elif hostile == "binary":
                await socket.send_bytes(b"\x00\xff")
            else:
                for _ in range(MOST_REQUESTS + 1):
                    await socket.send_str("{}")
            while (message := await socket.receive()).type is aiohttp.WSMsgType.TEXT:
                assert json.loads(message.data)["type"] == "refused"
            return socket.close_code, stand.asked

    code, asked = tell(story)
    assert code == (1009 if hostile == "large" else 1008)
    assert asked == [(1, None)]


async def log_in(stand, **fields):
    async with stand.session.post(
        f"{stand.base}/login", data=fields, allow_redirects=False
    ) as response:
        return response.status, response.headers.get("Set-Cookie")


def test_with_a_password_the_token_alone_leads_to_the_question_for_it(tell):
    async def story(stand):
        page = await stand.get(f"/?token={stand.access.token}", known=False)
        right = {"token": stand.access.token, "password": "correct horse"}
        return page, await log_in(stand, **right)

    (status, body, headers), (answer, cookie) = tell(story, "correct horse")
    assert status == 200
    assert b'type="password"' in body
    assert "Set-Cookie" not in headers
    assert answer == 303
    assert cookie


@pytest.mark.parametrize("fields", [{}, {"token": "x"}, {"password": "correct horse"}])
def test_a_password_without_the_token_opens_nothing(tell, fields):
    status, cookie = tell(lambda stand: log_in(stand, **fields), "correct horse")
    assert (status, cookie) == (403, None)


def test_passwords_are_tried_one_a_second_at_most(tell):
    async def story(stand):
        wrong = {"token": stand.access.token, "password": "wrong"}
        return [(await log_in(stand, **wrong))[0] for _ in range(3)]

    assert tell(story, "correct horse") == [403, 429, 429]


def test_a_login_of_many_bytes_is_not_read(tell):
    async def story(stand):
        return await log_in(stand, token="x" * 100_000)

    assert tell(story, "correct horse")[0] == 413
