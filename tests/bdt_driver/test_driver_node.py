"""The driver node: services, topics, times, diagnostics; the controller drives a carriage."""

import itertools
import os

import numpy as np
import pytest
from rail_drive import MADE
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger

from bdt_controller.controller_node import ControllerNode
from bdt_driver.driver_node import DriverNode
from bdt_msgs_py.node_parameters import ConfigurationError
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import read_samples
from bdt_msgs_py.topics import COMMAND, DIAGNOSTICS, MEASUREMENT, TELEMETRY, TELEMETRY_COLUMNS
from bdt_msgs_py.writing import motor_voltage

RATE = 100.0
DRIVE = {"driver": "rail_drive:RailDrive", "control_rate": RATE, "drive__period": 1 / RATE}


class Peer:
    """A node beside the driver: hears what it publishes, commands and calls its services."""

    def __init__(self, ros, **parameters):
        self.ros = ros
        self.node = ros.create(DriverNode, **(DRIVE | parameters))
        self.drive = MADE[-1]
        self.heard = {topic.name: [] for topic in (MEASUREMENT, TELEMETRY)}
        for kind, topic in ((JointState, MEASUREMENT), (Float64MultiArray, TELEMETRY)):
            self.node.create_subscription(
                kind, topic.name, self.heard[topic.name].append, qos_profile(topic)
            )
        self.commands = self.node.create_publisher(JointState, COMMAND.name, qos_profile(COMMAND))

    def measurements(self):
        return self.heard[MEASUREMENT.name]

    def batches(self):
        return [read_samples(each, TELEMETRY_COLUMNS) for each in self.heard[TELEMETRY.name]]

    def rows(self):
        return np.concatenate(self.batches())

    def call(self, service):
        client = self.node.create_client(Trigger, f"/driver/{service}")
        self.ros.spin_until(client.service_is_ready)
        return self.ros.result(client.call_async(Trigger.Request()))

    def answer(self, voltage, stamp=None):
        stamp = stamp or self.measurements()[-1].header.stamp
        self.commands.publish(motor_voltage(stamp.sec * 10**9 + stamp.nanosec, voltage))

    def be_obeyed(self):
        """Answer a measurement, and wait until the drive has the voltage."""
        self.ros.spin_until(self.measurements)
        self.answer(5.0)
        self.ros.spin_until(lambda: self.drive.written)


@pytest.fixture
def peer(ros):
    return Peer(ros)


def test_disarmed_it_reports_telemetry_and_asks_for_no_command(peer):
    peer.ros.spin_until(lambda: len(peer.heard[TELEMETRY.name]) >= 2)
    assert peer.measurements() == []
    np.testing.assert_array_equal(peer.rows()[:, 1:], 0.0)
    for batch in peer.batches():
        np.testing.assert_allclose(np.diff(batch[:, 0]), 1 / RATE, atol=1e-6)


def test_armed_it_obeys_the_answer_to_its_measurement(peer):
    peer.ros.spin_until(lambda: "read" in peer.drive.calls)
    answer = peer.call("arm")
    assert (answer.success, answer.message) == (True, "armed")
    peer.be_obeyed()
    assert 0.0 < peer.drive.written[0] <= 0.05


def test_armed_without_commands_it_says_so(peer):
    peer.ros.spin_until(lambda: "read" in peer.drive.calls)
    peer.call("arm")
    health = peer.node._health()
    assert not health.ok
    assert "armed, and no commands come" in health.summary
    peer.be_obeyed()
    assert "no commands come" not in peer.node._health().summary


def test_disarmed_during_motion_it_stops(peer):
    peer.ros.spin_until(lambda: "read" in peer.drive.calls)
    peer.call("arm")
    peer.ros.spin_until(peer.measurements)
    peer.answer(5.0)
    peer.ros.spin_until(lambda: peer.drive.voltage)
    answer = peer.call("disarm")
    assert (answer.success, answer.message) == (True, "open")
    assert peer.drive.voltage == 0.0


def test_a_command_that_answers_nothing_is_rejected(peer):
    peer.ros.spin_until(lambda: "read" in peer.drive.calls)
    peer.call("arm")
    peer.ros.spin_until(peer.measurements)
    stamp = peer.measurements()[-1].header.stamp
    stamp.sec += 1
    peer.answer(5.0, stamp)
    peer.ros.spin_until(lambda: peer.node._admission.rejected)
    assert peer.drive.written == []


def test_a_fault_is_told_and_refuses_arming(peer):
    peer.ros.spin_until(lambda: "read" in peer.drive.calls)
    peer.drive.failing = "read"
    peer.ros.spin_until(lambda: peer.node._health().is_error)
    health = peer.node._health()
    assert "OSError: read: the cable is pulled" in health.summary
    assert health.values["state"] == "faulted"
    answer = peer.call("arm")
    assert not answer.success
    assert "disarm it first" in answer.message
    peer.drive.failing = ""
    assert peer.call("disarm").success


def test_the_controller_brings_the_carriage_to_the_reference(ros):
    peer = Peer(ros)
    ros.create(
        ControllerNode,
        control_rate=RATE,
        reference__first=0.002,
        reference__second=0.002,
        pid__proportional=300.0,
        pid__integral=10.0,
        pid__derivative=0.0,
        use_sim_time=False,
    )
    ros.spin_until(lambda: "read" in peer.drive.calls)
    peer.call("arm")
    ros.spin_until(lambda: peer.drive.written)
    ros.spin_until(lambda: abs(peer.drive.position - 0.002) < 1e-4)
    peer.call("disarm")
    rows = peer.rows()
    times, moved = np.diff(rows[:, 0]), np.diff(rows[:, 2])
    even = np.isclose(times, 1 / RATE, atol=1e-6)
    assert even.sum() > 10
    np.testing.assert_allclose(moved[even], 0.004 / RATE * rows[:-1, 1][even], atol=1e-12)


def test_samples_of_the_drive_are_the_telemetry(ros):
    peer = Peer(ros, sampling_rate=400.0, drive__samples=4)
    ros.spin_until(lambda: len(peer.heard[TELEMETRY.name]) >= 2)
    for batch in peer.batches():
        np.testing.assert_allclose(np.diff(batch[:, 0]), 0.0025, rtol=0.01)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"driver": ""}, "parameter driver = '': must be module:name"),
        ({"driver": "rail_drive:NoStop"}, r"NoStop: .*(drive\.period|no method stop)"),
        ({"drive__port": "/dev/ttyUSB0"}, "does not take drive.period, drive.port"),
        ({"limits__voltage": 0.0}, "parameter limits.voltage = 0.0"),
        ({"colour": 1}, "parameter colour = 1: is not a parameter"),
    ],
)
def test_what_cannot_work_is_refused_in_a_line(ros, parameters, message):
    with pytest.raises(ConfigurationError, match=message):
        ros.create(DriverNode, **(DRIVE | parameters))


def test_limits_cannot_be_set_away_while_it_runs(peer):
    from rclpy.parameter import Parameter

    (result,) = peer.node.set_parameters([Parameter("limits.voltage", value=1000.0)])
    assert not result.successful


def test_its_end_stops_and_closes_the_drive(ros):
    peer = Peer(ros)
    ros.spin_until(lambda: "read" in peer.drive.calls)
    ros.close()
    assert peer.drive.calls[-2:] == ["stop", "close"]


def test_its_diagnostics_have_a_state(peer):
    from diagnostic_msgs.msg import DiagnosticArray

    heard = []
    peer.node.create_subscription(
        DiagnosticArray, DIAGNOSTICS.name, heard.append, qos_profile(DIAGNOSTICS)
    )
    peer.ros.spin_until(lambda: heard)
    values = {pair.key: pair.value for pair in heard[0].status[0].values}
    assert values["state"] == "open"


def test_garbage_waits_until_the_command_is_applied(peer, monkeypatch):
    done = []
    monkeypatch.setattr(peer.node._process, "use_slack", lambda: done.append("slack"))
    peer.ros.spin_until(lambda: done)  # nobody commands: after the reading
    peer.call("arm")
    peer.ros.spin_until(peer.measurements)
    done.clear()
    monkeypatch.setattr(peer.node._loop, "command", lambda *_: done.append("command"))
    peer.answer(5.0)
    peer.ros.spin_until(lambda: "command" in done)
    assert done[done.index("command") + 1] == "slack"


def test_telemetry_waits_until_the_command_is_applied(peer, monkeypatch):
    done = []

    def note(owner, name):
        original = getattr(owner, name)
        monkeypatch.setattr(owner, name, lambda *given: [done.append(name), original(*given)][1])

    def answered():
        if peer.measurements() and "tick" in done[-1:]:
            peer.answer(5.0)
        return ("command", "publish") in itertools.pairwise(done)

    peer.node._batch = 1
    peer.ros.spin_until(lambda: "read" in peer.drive.calls)
    peer.call("arm")
    for owner, name in (
        (peer.node._loop, "tick"),
        (peer.node._loop, "command"),
        (peer.node._telemetry, "publish"),
    ):
        note(owner, name)
    peer.ros.spin_until(answered)


def test_telemetry_goes_on_when_no_command_comes(peer):
    peer.ros.spin_until(lambda: "read" in peer.drive.calls)
    peer.call("arm")
    peer.be_obeyed()
    before = len(peer.batches())
    peer.ros.spin_until(lambda: len(peer.batches()) > before + 2)
    for batch in peer.batches():
        np.testing.assert_allclose(np.diff(batch[:, 0]), 1 / RATE, atol=1e-6)


def test_a_priority_that_is_refused_is_a_warning_and_the_drive_is_driven(ros, monkeypatch):
    def refuse(*_):
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    peer = Peer(ros, real_time__priority=50)
    peer.ros.spin_until(lambda: "read" in peer.drive.calls)
    health = peer.node._health()
    assert not health.ok
    assert "real_time.priority = 50: refused" in health.summary
    assert peer.call("arm").success
