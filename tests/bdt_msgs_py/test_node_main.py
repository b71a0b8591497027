"""A node as a process: one-line errors, exit codes, signals."""

import os
import signal
import subprocess
import sys

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from sensor_msgs.msg import JointState

from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_stamp
from bdt_msgs_py.topics import COMMAND, DIAGNOSTICS

DEADLINE = 60.0
MODULES = {
    "plant": "bdt_plant.plant_node",
    "controller": "bdt_controller.controller_node",
    "twin": "bdt_twin.twin_node",
}
RECORDER = {"recorder": "bdt_bags.recorder.recorder_node"}


def node(name, *arguments, safe=False, cwd=None):
    return subprocess.Popen(
        [
            sys.executable,
            *(["-P"] if safe else []),
            "-m",
            (MODULES | RECORDER)[name],
            "--ros-args",
            *arguments,
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=cwd,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )


def ends(processes):
    """Yield exit code, output and errors of processes that run at the same time."""
    for process in processes:
        out, err = process.communicate(timeout=DEADLINE)
        yield process.returncode, out, err


def test_an_unknown_parameter_is_one_line_and_exit_code_two():
    started = [node(name, "-p", "no_such:=1.0") for name in MODULES]
    for name, end in zip(MODULES, ends(started), strict=True):
        text = f"error: parameter no_such = 1.0: is not a parameter of /{name}\n"
        assert end == (2, "", text)


def test_a_value_that_is_not_allowed_is_one_line_and_exit_code_two():
    values = ["-1.0", ".nan", "5", "wide", "[1.0]"]
    started = [node("controller", "-p", f"dead_zone_tolerance:={value}") for value in values]
    for value, (code, _, err) in zip(values, ends(started), strict=True):
        assert code == 2, value
        assert err.startswith("error: parameter dead_zone_tolerance = "), value
        assert "0 to 0.1 m" in err, value
        assert err.count("\n") == 1, value


def test_a_parameter_file_that_is_missing_is_named(tmp_path):
    process = node("controller", "--params-file", str(tmp_path / "none.yaml"))
    _, err = process.communicate(timeout=DEADLINE)
    assert process.returncode == 2
    assert "none.yaml" in err
    assert "Traceback" not in err


def test_a_parameter_file_that_holds_nothing_for_the_node_is_refused(tmp_path):
    path = tmp_path / "file.yaml"
    path.write_text("plant: {ros__parameters: {duration: 0.1}}\n")
    words = ("-r", "__ns:=/left", "--params-file", str(path))
    for name, end in zip(MODULES, ends([node(name, *words) for name in MODULES]), strict=True):
        text = (
            f"error: parameter file {path}: holds nothing for /left/{name}, its sections are "
            f"plant; a section /**/{name} is for this node in any namespace\n"
        )
        assert end == (2, "", text)


def test_the_recorder_that_shares_the_file_of_the_loop_says_so_and_records(ros, tmp_path):
    said = []
    listener = ros.create(Node, "listener")
    listener.create_subscription(
        DiagnosticArray, DIAGNOSTICS.name, said.append, qos_profile(DIAGNOSTICS)
    )
    path = tmp_path / "file.yaml"
    path.write_text("plant: {ros__parameters: {duration: 0.1}}\n")
    bag = tmp_path / "bag"
    process = node("recorder", "--params-file", str(path), "-p", f"bag:={bag}")
    assert f"parameter file {path}: holds nothing for /recorder" in process.stderr.readline()
    ros.spin_until(lambda: said, DEADLINE)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=DEADLINE)
    assert process.returncode == 0, err
    assert (bag / "metadata.yaml").exists()


BROKEN = """
class MyEstimator:
    def restart(self):
        self.rows = none

    def update(self, batch):
        pass
"""


def test_an_estimator_that_cannot_be_made_is_one_line_with_its_place_and_exit_code_two(tmp_path):
    (tmp_path / "my_file.py").write_text(BROKEN)
    # As `ros2 run` starts it: the current folder is none that Python looks into.
    process = node("twin", "-p", "estimator.kind:=my_file:MyEstimator", safe=True, cwd=tmp_path)
    _, err = process.communicate(timeout=DEADLINE)
    assert err == (
        "error: parameter estimator.kind = 'my_file:MyEstimator': my_file.py:4: NameError: "
        "name 'none' is not defined\n"
    )
    assert process.returncode == 2


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_node_without_complaint(number):
    process = node("plant", "-p", "resend_period:=0.05")
    line = process.stderr.readline()
    assert "waiting for a command" in line
    process.send_signal(number)
    _, err = process.communicate(timeout=DEADLINE)
    assert process.returncode == 0
    assert "Traceback" not in err


INTERRUPTED = """
import atexit, os, signal, sys
from functools import partial
import rclpy
from rclpy.node import Node
from rclpy.task import Future
from bdt_msgs_py.node_main import run_node

def at(place, places=sys.argv[1:], interrupt=partial(os.kill, os.getpid(), signal.SIGINT)):
    if place in places:
        interrupt()

class MyNode(Node):
    def __init__(self):
        super().__init__("my_node")
        at("creation")
        self.create_timer(0.0, self.work)
        self.finished = Future()

    def work(self):
        at("work")
        exec("at('text')")
        self.finished.set_result(None)

    def destroy_node(self):
        at("end")
        super().destroy_node()
        print("destroyed")

class Module:
    def __del__(self, at=at):
        at("last")

atexit.register(at, "exit")
module = Module()
code = run_node(MyNode, [])
print(rclpy.ok())
sys.exit(code)
"""


@pytest.mark.parametrize(
    "places",
    [
        ("creation",),
        ("work",),
        ("text",),
        ("end",),
        ("exit",),
        ("last",),
        ("work", "end", "exit", "last"),
    ],
)
def test_ctrl_c_at_any_time_ends_a_node_without_complaint(places, tmp_path):
    (tmp_path / "my_node.py").write_text(INTERRUPTED)
    process = subprocess.Popen(
        [sys.executable, "-m", "my_node", *places],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    destroyed = "" if places == ("creation",) else "destroyed\n"
    assert list(ends([process])) == [(0, f"{destroyed}False\n", "")]


def test_a_plant_whose_controller_is_gone_ends_with_exit_code_one(ros):
    stamps = set()
    listener = ros.create(Node, "listener")
    listener.create_subscription(
        JointState,
        COMMAND.name,
        lambda command: stamps.add(nanoseconds_from_stamp(command.header.stamp)),
        qos_profile(COMMAND),
    )
    plant = node("plant", "-p", "resend_period:=0.05", "-p", "lockstep_timeout:=0.3")
    controller = node("controller")
    # A command of a second instant says that the plant took the first; the listener alone may
    # have heard that one. Then the controller is taken away.
    ros.spin_until(lambda: len(stamps) > 1, DEADLINE)
    controller.kill()
    controller.communicate(timeout=DEADLINE)
    _, err = plant.communicate(timeout=DEADLINE)
    assert plant.returncode == 1
    assert "error: /plant waited" in err
    assert "for a command" in err
