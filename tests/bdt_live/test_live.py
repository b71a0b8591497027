"""The command `bdt live`: what it refuses, and a loop that somebody else has started."""

import asyncio
import os

import aiohttp
import pytest

from bdt_bringup.cli import run_command
from bdt_live.measuring.process_load import tree_of, words_of
from bdt_live.niceness import PAGE_NICENESS
from bdt_msgs_py.command_errors import BAD_INPUT


@pytest.fixture
def password_file(tmp_path):
    file = tmp_path / "password"
    file.write_text("short\n")
    return file


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--port", "65536"], "--port 65536: must be 0 to 65535"),
        (["--host", "10.0.0.1"], "--host and --password-file: must be given together"),
        (["--password-file", "x"], "--host and --password-file: must be given together"),
        (["--host", "10.0.0.1", "--password-file", "/none"], "--password-file /none: "),
        (["--host", "0.0.0.0", "--password-file", "PASSWORD"], "--host 0.0.0.0: "),  # noqa: S104
        (["--host", "10.0.0.1", "--password-file", "PASSWORD"], "must begin with 8 characters"),
        (["--config", "none_such"], "--config none_such: "),
        (["--namespace", "a b"], "--namespace a b: "),
    ],
)
def test_what_cannot_be_is_one_line(options, complaint, password_file, capsys):
    arguments = [str(password_file) if each == "PASSWORD" else each for each in options]
    assert run_command(["live", *arguments]) == BAD_INPUT
    said = capsys.readouterr().err
    assert complaint in said
    assert said.count("\n") == 1


def test_a_loop_that_runs_already_is_attached_to(live_loop, beside):
    program = beside("--attach", domain=live_loop.domain)

    async def first_frame():
        base = program.address.split("/?", maxsplit=1)[0]
        jar = aiohttp.CookieJar(unsafe=True)
        async with aiohttp.ClientSession(cookie_jar=jar) as session:
            async with session.get(program.address) as answer:
                assert answer.status == 200
            async with session.ws_connect(f"{base}/socket", headers={"Origin": base}) as socket:
                while True:
                    message = await socket.receive_json(timeout=60.0)
                    if message["type"] == "frame":
                        return message

    assert asyncio.run(first_frame())["rows"]


def nicenesses_of(module, processes):
    return [os.getpriority(os.PRIO_PROCESS, each) for each in processes if module in words_of(each)]


def test_the_process_of_ros_lets_the_nodes_go_first(live_loop):
    processes, ours = tree_of(live_loop.process.pid), os.getpriority(os.PRIO_PROCESS, 0)
    # Only a privileged user may be less nice than before.
    assert nicenesses_of("bdt_live.ros_process", processes) == [max(ours, PAGE_NICENESS)]
    for node in ("bdt_plant.plant_node", "bdt_controller.controller_node"):
        assert nicenesses_of(node, processes) == [ours]


def test_a_port_that_is_taken_is_told(live_loop, beside):
    program = beside("--attach", domain=live_loop.domain, port=live_loop.port, is_awaited=False)
    program.process.wait(timeout=60)
    assert program.process.returncode == BAD_INPUT
    assert program.process.stderr.read().startswith(
        f"error: --port {live_loop.port}: cannot listen"
    )
    assert not program.output.exists()
