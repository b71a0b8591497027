"""Nodes as processes that are killed and started anew: what was in force is in force again."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import ParameterEvent
from rclpy.node import Node

from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import DIAGNOSTICS, PARAMETER_EVENTS

DEADLINE = 60.0
MODULES = {
    "plant": "bdt_plant.plant_node",
    "controller": "bdt_controller.controller_node",
    "twin": "bdt_twin.twin_node",
}
DELAY = 0.2


class Loop:
    """A loop in real time, node by node, and what its controllers say of their dead zones."""

    def __init__(self, ros, folder):
        self.ros, self.state_file, self.running = ros, folder / "twin.json", {}
        self.events, self.said = [], {}
        listener = ros.create(Node, "listener")
        listener.create_subscription(
            ParameterEvent, PARAMETER_EVENTS.name, self._hear, qos_profile(PARAMETER_EVENTS)
        )
        listener.create_subscription(
            DiagnosticArray, DIAGNOSTICS.name, self._hear_twin, qos_profile(DIAGNOSTICS)
        )
        self.parameters = {
            "plant": ["mode:=realtime", "gap.kind:=constant", "gap.initial:=0.2"],
            "controller": ["use_sim_time:=true", "reference.step_time:=1.0"],
            "twin": [
                "use_sim_time:=true",
                f"communication_delay:={DELAY}",
                f"state_file:={self.state_file}",
            ],
        }

    def _hear(self, event):
        if event.node == "/controller":
            for parameters, is_new in (
                (event.new_parameters, True),
                (event.changed_parameters, False),
            ):
                self.events += [
                    (is_new, parameter.value.double_value)
                    for parameter in parameters
                    if parameter.name == "dead_zone_tolerance"
                ]

    def _hear_twin(self, message):
        (status,) = message.status
        if status.name == "/twin":
            self.said = {each.key: each.value for each in status.values}

    def start(self, *names):
        for name in names:
            options = [word for one in self.parameters[name] for word in ("-p", one)]
            command = [sys.executable, "-m", MODULES[name], "--ros-args", *options]
            self.running[name] = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)

    def kill(self, *names):
        for name in names:
            self.running[name].send_signal(signal.SIGKILL)
        for name in names:
            self.running.pop(name).communicate()

    def wait_for_the_twin(self):
        """Wait until a controller has got a dead zone, and return it [m]."""
        self.events.clear()
        self.ros.spin_until(lambda: any(not is_new for is_new, _ in self.events), DEADLINE)
        return self.events[-1][1]

    def kept(self):
        return json.loads(self.state_file.read_text())["state"]["in_force"]["dead_zone_tolerance"]


@pytest.fixture
def loop(ros, tmp_path):
    loop = Loop(ros, tmp_path)
    loop.start("plant", "controller", "twin")
    assert loop.wait_for_the_twin() > 0.0
    yield loop
    loop.kill(*loop.running)


def test_a_killed_controller_gets_the_dead_zone_back_with_the_link_s_delay(ros, loop):
    loop.kill("controller")
    loop.events.clear()
    loop.start("controller")
    ros.spin_until(lambda: any(is_new for is_new, _ in loop.events), DEADLINE)
    begin = time.monotonic()
    ros.spin_until(lambda: not loop.events[-1][0], DEADLINE)
    took = time.monotonic() - begin
    assert took < DELAY + 1.0, took
    assert loop.events[-1][1] > 0.0


def test_a_killed_twin_leaves_the_dead_zone_and_its_successor_passes_it_on(ros, loop):
    loop.kill("twin")
    ros.spin_for(0.3)
    *_, (_, before) = loop.events
    loop.events.clear()
    # Nothing moves, so that nothing is learned: what the new twin passes on it was left.
    loop.kill("plant")
    loop.said.clear()
    loop.start("twin")
    ros.spin_until(lambda: loop.said.get("dead_zone_set_by") == "before the twin came", DEADLINE)
    assert loop.events == []
    loop.kill("controller")
    loop.start("controller", "plant")
    ros.spin_until(lambda: any(not is_new for is_new, _ in loop.events), DEADLINE)
    assert next(value for is_new, value in loop.events if not is_new) == before


def test_what_is_in_force_survives_a_kill_of_all_nodes(ros, loop):
    ros.spin_until(loop.state_file.exists, DEADLINE)
    loop.kill("twin", "controller", "plant")
    kept = loop.kept()
    loop.events.clear()
    loop.start("plant", "controller", "twin")
    ros.spin_until(lambda: any(not is_new for is_new, _ in loop.events), DEADLINE)
    first = next(value for is_new, value in loop.events if not is_new)
    assert first == kept > 0.0
    assert not os.path.lexists(loop.state_file.with_suffix(".tmp"))
