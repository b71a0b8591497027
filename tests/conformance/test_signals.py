"""Signals end a program as with rclpy: Ctrl-C interrupts, SIGTERM shuts down."""

import signal
import subprocess
import sys
import time

import pytest

DEADLINE = 60.0
"""Wall time [s] after which a signal counts as missed."""

PROGRAM = """
import sys, threading, time
import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

how = sys.argv[1]
options = SignalHandlerOptions.NO if how == "no handlers" else None
rclpy.init(args=[], signal_handler_options=options)
node = Node("n")
spun = threading.Event()

def say(*words):
    # In one piece: two threads write.
    sys.stdout.write(" ".join(map(str, words)) + "\\n")
    sys.stdout.flush()

def spin(name):
    try:
        rclpy.spin(node)
        say(name, "ended")
    except Exception:
        # ExternalShutdownException, but not if the signal came between two waits; and rclpy 7.1
        # may stumble over the context that is gone.
        say(name, "ended")
    except KeyboardInterrupt:
        say(name, "KeyboardInterrupt")
    spun.set()

def ready():
    say("ready")

if how == "waiting":
    ready()
else:
    # In the spin, and with a timer: rclpy 7.1 may miss a signal that comes while a wait begins.
    node.create_guard_condition(ready).trigger()
    node.create_timer(0.1, lambda: None)
if how == "thread":
    spinner = threading.Thread(target=spin, args=("thread",))
    spinner.start()
    try:
        spinner.join()
        say("main joined")
    except KeyboardInterrupt:
        say("main KeyboardInterrupt")
        spun.wait(20)  # after an interrupted join, Python 3.12 takes the thread for ended
elif how == "waiting":
    from std_srvs.srv import Trigger
    client = node.create_client(Trigger, "never")
    try:
        say("main", client.wait_for_service())
    except BaseException as error:
        say("main", type(error).__name__)
else:
    spin("main")
end = time.monotonic() + 20
while rclpy.ok() and time.monotonic() < end:
    time.sleep(0.01)  # rclpy's handler shuts down in a thread of its own
say("ok" if rclpy.ok() else "not ok")
node.destroy_node()
rclpy.try_shutdown()
"""


def signaled(process, number):
    """Send a signal that must end the process. Return its outputs."""
    process.send_signal(number)
    try:
        return process.communicate(timeout=DEADLINE)
    except subprocess.TimeoutExpired:
        process.kill()
        raise


@pytest.mark.parametrize(
    ("how", "number", "lines", "code"),
    [
        ("spin", signal.SIGINT, ["main KeyboardInterrupt", "not ok"], 0),
        ("spin", signal.SIGTERM, ["main ended", "not ok"], 0),
        ("thread", signal.SIGINT, ["main KeyboardInterrupt", "thread ended", "not ok"], 0),
        ("thread", signal.SIGTERM, ["thread ended", "main joined", "not ok"], 0),
        # Not SIGINT without handlers: rclpy 7.1 sees it when the wait ends, which may be never.
        ("no handlers", signal.SIGTERM, [], -signal.SIGTERM),
        ("waiting", signal.SIGINT, ["main KeyboardInterrupt", "not ok"], 0),
        ("waiting", signal.SIGTERM, ["main RCLError", "not ok"], 0),
    ],
)
def test_a_signal_ends_a_blocked_program(how, number, lines, code):
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM, how],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.1)  # let it block; that it does cannot be seen from here
        out, errors = signaled(process, number)
    assert sorted(out.splitlines()) == sorted(lines)
    assert process.returncode == code
    assert errors == ""


def test_ctrl_c_ends_a_program_that_a_shell_started_in_the_background():
    """Such a program inherits that SIGINT is ignored; the handlers of rclpy replace that."""
    ignoring = ["bash", "-c", "trap '' INT; exec \"$@\"", "bash"]
    with subprocess.Popen(
        [*ignoring, sys.executable, "-c", PROGRAM, "spin"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout.readline() == "ready\n"
        out, errors = signaled(process, signal.SIGINT)
    assert out.splitlines() == ["main ended", "not ok"]
    assert process.returncode == 0
    assert errors == ""
