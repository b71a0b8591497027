"""Signals, where embedded_ros does better than rclpy."""

import signal
import subprocess
import sys
import time

import pytest

TIMEOUT_S = 120

PROGRAM = """
import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
node = Node("n")
print("ready", flush=True)
try:
    rclpy.spin(node)
except KeyboardInterrupt:
    print("interrupted", rclpy.ok(), flush=True)
node.destroy_node()
rclpy.shutdown()
"""


def test_ctrl_c_ends_a_wait_at_once_without_handlers():
    # rclpy 7.1 goes on waiting until something else ends the wait.
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.1)  # let it block; that it does cannot be seen from here
        process.send_signal(signal.SIGINT)
        out, errors = process.communicate(timeout=TIMEOUT_S)
    assert out == "interrupted True\n"
    assert process.returncode == 0
    assert errors == ""


SPINNING = """
import rclpy
from rclpy.node import Node
rclpy.init(args=[])
node = Node("n")
print("ready", flush=True)
try:
    rclpy.spin(node)
except BaseException as error:
    print(type(error).__name__, rclpy.ok(), flush=True)
node.destroy_node()
rclpy.try_shutdown()
"""


@pytest.mark.parametrize(
    ("number", "error"),
    [(signal.SIGINT, "KeyboardInterrupt"), (signal.SIGTERM, "ExternalShutdownException")],
)
def test_a_signal_ends_a_wait_that_nothing_else_ends(number, error):
    # rclpy 7.1 misses one now and then.
    with subprocess.Popen(
        [sys.executable, "-c", SPINNING], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.1)  # let it block; that it does cannot be seen from here
        process.send_signal(number)
        out, errors = process.communicate(timeout=TIMEOUT_S)
    assert (out, errors, process.returncode) == (f"{error} False\n", "", 0)


OUTLIVED = """
import os, signal, threading, time
from rclpy.context import Context
from rclpy.signals import install_signal_handlers

def initialized():
    context = Context()
    context.init([])
    return context

install_signal_handlers()
before = initialized()
# Another thread than main cannot take the wake-up descriptor back from the interpreter.
ender = threading.Thread(target=before.shutdown)
ender.start()
ender.join()
os.kill(os.getpid(), signal.SIGTERM)
outlived = set()
descriptors = set()
for _ in range(20):
    context = initialized()
    time.sleep(0.02)  # for what should not happen
    outlived.add(context.ok())
    os.kill(os.getpid(), signal.SIGTERM)
    context.try_shutdown()
    descriptors.add(len(os.listdir("/proc/self/fd")))
print(outlived, len(descriptors), threading.active_count())
"""


def test_a_context_outlives_the_signals_from_before_it():
    done = subprocess.run(
        [sys.executable, "-c", OUTLIVED],
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=True,
    )
    assert (done.stdout, done.stderr) == ("{True} 1 1\n", "")
