"""Signals end a program as with rclpy: Ctrl-C interrupts, SIGTERM shuts down."""

import signal
import subprocess
import sys
import time

import pytest

PROGRAM = """
import sys, threading, time
import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

how = sys.argv[1]
options = SignalHandlerOptions.NO if how == "no handlers" else None
rclpy.init(args=[], signal_handler_options=options)
node = Node("n")
spinner = None
spun = threading.Event()

def spin(name):
    try:
        rclpy.spin(node)
        print(name, "returned", flush=True)
    except BaseException as error:
        print(name, type(error).__name__, flush=True)
    spun.set()

print("ready", flush=True)
if how == "thread":
    spinner = threading.Thread(target=spin, args=("thread",))
    spinner.start()
    try:
        spinner.join()
        print("main joined", flush=True)
    except KeyboardInterrupt:
        print("main KeyboardInterrupt", flush=True)
        spun.wait(5)  # after an interrupted join, Python 3.12 takes the thread for ended
elif how == "waiting":
    from std_srvs.srv import Trigger
    client = node.create_client(Trigger, "never")
    try:
        print("main", client.wait_for_service(), flush=True)
    except BaseException as error:
        print("main", type(error).__name__, flush=True)
else:
    spin("main")
print("ok" if rclpy.ok() else "not ok", flush=True)
node.destroy_node()
rclpy.try_shutdown()
"""


@pytest.mark.parametrize(
    ("how", "number", "lines", "code"),
    [
        ("spin", signal.SIGINT, ["main KeyboardInterrupt", "not ok"], 0),
        ("spin", signal.SIGTERM, ["main ExternalShutdownException", "not ok"], 0),
        (
            "thread",
            signal.SIGINT,
            ["main KeyboardInterrupt", "thread ExternalShutdownException", "not ok"],
            0,
        ),
        (
            "thread",
            signal.SIGTERM,
            ["thread ExternalShutdownException", "main joined", "not ok"],
            0,
        ),
        ("no handlers", signal.SIGINT, ["main KeyboardInterrupt", "ok"], 0),
        ("no handlers", signal.SIGTERM, [], -signal.SIGTERM),
        ("waiting", signal.SIGINT, ["main KeyboardInterrupt", "not ok"], 0),
        ("waiting", signal.SIGTERM, ["main RCLError", "not ok"], 0),
    ],
)
def test_a_signal_ends_a_blocked_program_at_once(how, number, lines, code):
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM, how],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.1)  # let it block; that it does cannot be seen from here
        start = time.monotonic()
        process.send_signal(number)
        out, errors = process.communicate(timeout=10)
        assert time.monotonic() - start < 2
    assert sorted(out.splitlines()) == sorted(lines)
    assert process.returncode == code
    assert errors == ""


def test_ctrl_c_ends_a_program_that_a_shell_started_in_the_background():
    """Such a program inherits that SIGINT is ignored; the handlers of rclpy replace that.

    As with rclpy, a signal that comes before or between two waits lets ``spin`` return; one that
    comes during a wait raises.
    """
    ignoring = ["bash", "-c", "trap '' INT; exec \"$@\"", "bash"]
    with subprocess.Popen(
        [*ignoring, sys.executable, "-c", PROGRAM, "spin"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout.readline() == "ready\n"
        process.send_signal(signal.SIGINT)
        out, errors = process.communicate(timeout=10)
    spun, ended = out.splitlines()
    assert spun in {"main returned", "main ExternalShutdownException"}
    assert ended == "not ok"
    assert process.returncode == 0
    assert errors == ""
