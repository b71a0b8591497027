"""The node behind the page, with a controller beside it and the process of the page played here."""

import json
from functools import partial

import numpy as np
import pytest
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from bdt_bags.reading.recording import load_recording
from bdt_controller.controller_node import ControllerNode
from bdt_live.channel import Channel, channel_pair
from bdt_live.extremes import COLUMNS
from bdt_live.from_server import page_asks, page_has_come
from bdt_live.live_node import STATE_PERIOD, LiveNode
from bdt_live.page_requests import NODES
from bdt_live.short_looks import ENOUGH
from bdt_msgs_py.qos import publisher_profile, qos_profile
from bdt_msgs_py.topics import (
    COMMAND,
    MEASUREMENT,
    TELEMETRY,
    TELEMETRY_COLUMNS,
    TRUTH,
    TRUTH_COLUMNS,
)
from bdt_msgs_py.writing import platform_position, sample_message


class Stand:
    """A live node with somebody who takes what it tells and asks it."""

    def __init__(self, ros, output, live_node=LiveNode):
        self.ros, self.told = ros, []
        own, other = channel_pair()
        self.channel, self.node_channel = Channel(own), Channel(other)
        self.controller = ros.create(ControllerNode, dead_zone_tolerance=2e-5)
        self.live = ros.create(live_node, self.node_channel, output)

    def hear(self, kind, **fields):
        """Return the first message of a kind that has these fields, once it is there."""
        found = []

        def look():
            self.told += [json.loads(text) for text in self.channel.receive() or ()]
            found[:] = [
                each
                for each in self.told
                if each["type"] == kind and fields.items() <= each.items()
            ]
            return found

        self.ros.spin_until(look)
        self.told.remove(found[0])
        return found[0]

    def ask(self, number, action, **fields):
        """Ask as a page does, and return the reason why not."""
        request = json.dumps({"number": number, "action": action, **fields})
        self.channel.send(page_asks(7, request))
        reply = self.hear("reply", number=number)
        assert reply["page"] == 7
        return reply["reason"]

    def controls(self, node="controller"):
        """Return the controls of a node by name, once it has told them."""
        while True:
            told = self.hear("parameters", node=node)["controls"]
            if told:
                return {control["name"]: control for control in told}

    def close(self):
        """Close both ends."""
        self.channel.close()
        self.node_channel.close()


@pytest.fixture
def stand(ros, tmp_path):
    made = Stand(ros, tmp_path)
    yield made
    made.close()


def test_the_parameters_of_a_node_that_is_there_are_told_with_what_it_says_of_them(stand):
    controls = stand.controls()
    dead_zone = controls["dead_zone_tolerance"]
    assert (dead_zone["kind"], dead_zone["value"], dead_zone["unit"]) == ("slider", 2e-5, "m")
    assert controls["reference.kind"]["kind"] == "fixed"


def test_a_page_that_comes_hears_of_every_node(stand):
    stand.controls()
    stand.channel.send(page_has_come())
    for name in NODES:
        stand.hear("parameters", node=name)


def test_a_value_is_set_told_to_all_and_refused_with_the_node_s_own_reason(stand):
    stand.controls()
    values = {"pid.proportional": 3000}
    assert stand.ask(1, "set", node="controller", values=values) is None
    assert stand.hear("values", node="controller")["values"] == {"pid.proportional": 3000.0}
    reason = stand.ask(2, "set", node="controller", values={"dead_zone_tolerance": -1.0})
    assert reason
    assert stand.controller._settings.dead_zone_tolerance == 2e-5
    assert stand.ask(3, "set", node="controller", values={"no.such": 1.0})


def test_a_node_that_is_not_there_cannot_be_asked(stand):
    assert stand.ask(1, "set", node="plant", values={"gap.initial": 0.1}) == "plant is not there"
    assert stand.ask(2, "pause") == "plant is not there"


def test_what_somebody_else_has_set_is_told(stand):
    stand.controls()
    stand.controller.set_parameters([Parameter("pid.integral", value=1000.0)])
    assert stand.hear("values", node="controller")["values"] == {"pid.integral": 1000.0}


def test_samples_and_marks_become_frames_and_a_bag_of_what_was_said(stand, tmp_path):
    machine = stand.ros.create(Node, "machine")
    telemetry, truth = (
        machine.create_publisher(Float64MultiArray, topic.name, publisher_profile(topic))
        for topic in (TELEMETRY, TRUTH)
    )
    stand.ros.spin_until(lambda: telemetry.get_subscription_count() == 1)
    times = np.arange(1000) / 5000
    rows = np.column_stack([times, np.ones(1000), np.full(1000, 2e-3)])
    known = np.column_stack([times[::10], *np.full((6, 100), 0.3)])
    stand.ros.spin_until(lambda: truth.get_subscription_count() == 1)
    truth.publish(sample_message(known, TRUTH_COLUMNS))
    telemetry.publish(sample_message(rows, TELEMETRY_COLUMNS))
    (first, *_) = stand.hear("frame")["rows"]
    shown = dict(zip(COLUMNS, first, strict=True))
    assert (shown["voltage_first"], shown["position"], shown["gap"]) == (1.0, 2e-3, 0.3)
    assert shown["dead_zone"] in {2e-5, None}
    assert stand.ask(1, "mark") is None
    assert stand.hear("marks", times=[times[-1]])
    assert stand.ask(2, "save") is None
    saved = stand.hear("saved")
    assert saved["reason"] is None
    recording = load_recording(tmp_path / saved["bag"])
    np.testing.assert_array_equal(recording.telemetry, rows)
    assert recording.marks == (times[-1],)
    stand.channel.send(page_has_come())
    assert stand.hear("marks", times=[times[-1]])
    telemetry.publish(sample_message(rows, TELEMETRY_COLUMNS))
    assert stand.hear("marks", times=[])


@pytest.fixture
def sparing_stand(ros, tmp_path):
    made = Stand(ros, tmp_path, partial(LiveNode, spares_loop=True))
    yield made
    made.close()


def test_a_loop_that_waits_for_nobody_is_timed_by_few_of_its_measurements(sparing_stand, tmp_path):
    stand = sparing_stand
    machine = stand.ros.create(Node, "machine")
    measurement = machine.create_publisher(
        JointState, MEASUREMENT.name, publisher_profile(MEASUREMENT)
    )
    telemetry = machine.create_publisher(
        Float64MultiArray, TELEMETRY.name, publisher_profile(TELEMETRY)
    )
    answers = []
    machine.create_subscription(JointState, COMMAND.name, answers.append, qos_profile(COMMAND))
    stand.ros.spin_until(lambda: measurement.get_subscription_count() == 2)
    stand.ros.spin_until(lambda: stand.controller.count_subscribers(COMMAND.name) == 2)
    for number in range(1, 2 * ENOUGH):
        measurement.publish(platform_position(2_000_000 * number, 2e-3))
        stand.ros.spin_until(lambda asked=number: len(answers) == asked)
        telemetry.publish(sample_message(np.array([[2e-3 * number, 1.0, 2e-3]]), TELEMETRY_COLUMNS))
    stand.ros.spin_until(lambda: measurement.get_subscription_count() == 1)
    latency = None
    while latency is None:
        latency = stand.hear("state")["latency"]
    assert 0.0 < latency < 1.0
    assert stand.ask(1, "save") is None
    recording = load_recording(tmp_path / stand.hear("saved")["bag"])
    assert "no measurement: the timing of the loop is that of telemetry" in recording.missing
    assert recording.message_counts[f"/{COMMAND.name}"] == len(answers)


def test_there_is_nothing_to_mark_before_the_loop_is_heard(stand):
    assert stand.ask(1, "mark") == "nothing has been heard of the loop yet"


def test_the_health_of_nodes_is_told(stand):
    nodes = []
    while not nodes:
        nodes = stand.hear("state")["nodes"]
    assert [node["name"] for node in nodes] == ["controller"]


def test_it_ends_with_the_process_of_the_page(stand):
    stand.channel.close()
    stand.ros.spin_until(lambda: stand.live.is_alone)


def test_a_pause_is_told_at_once_not_with_the_next_look_at_the_nodes(stand):
    plant = stand.ros.create(Node, "plant")
    for name, value in {"pause_at": 1e9, "pace": 1.0}.items():
        plant.declare_parameter(name, value)
    stand.controls("plant")
    for timer in stand.live.timers:
        if timer.timer_period_ns == STATE_PERIOD * 1e9:
            timer.cancel()
    for action, is_paused in [("pause", True), ("resume", False)] * 2:
        stand.told.clear()
        assert stand.ask(1, action) is None
        stand.hear("state", paused=is_paused)
