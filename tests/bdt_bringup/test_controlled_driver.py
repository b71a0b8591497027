"""Driver and controller in one process: who answers whom, and what each of them is told."""

import signal

import pytest
from driver_processes import DEADLINE, start_driver, wait_until_read
from rail_drive import MADE
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from bdt_bringup.controlled_driver import ControlledDriver
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_stamp
from bdt_msgs_py.topics import COMMAND, MEASUREMENT

MODULE = "bdt_bringup.controlled_driver"
DRIVER = "driver:driver:=rail_drive:RailDrive"
RATE = 100.0
DRIVE = {"driver": "rail_drive:RailDrive", "control_rate": RATE, "drive__period": 1 / RATE}
CONTROLLER = {
    "control_rate": RATE,
    "reference__first": 0.002,
    "reference__second": 0.002,
    "pid__proportional": 300.0,
    "pid__integral": 10.0,
    "pid__derivative": 0.0,
}


class Process:
    """Both nodes, and a listener."""

    def __init__(self, ros, **controller):
        nodes = ControlledDriver()
        self.ros = ros
        self.controller = ros.create(nodes.controller, **(CONTROLLER | controller))
        self.driver = ros.create(nodes.driver, **DRIVE)
        self.drive = MADE[-1]
        self.listener = ros.create(Node, "listener")
        self.heard = {MEASUREMENT: [], COMMAND: []}
        for topic, stamps in self.heard.items():
            self.listener.create_subscription(
                JointState,
                topic.name,
                lambda message, stamps=stamps: stamps.append(
                    nanoseconds_from_stamp(message.header.stamp)
                ),
                qos_profile(topic),
            )

    def arm(self):
        client = self.listener.create_client(Trigger, "/driver/arm")
        self.ros.spin_until(client.service_is_ready)
        self.ros.spin_until(lambda: "read" in self.drive.calls)
        assert self.ros.result(client.call_async(Trigger.Request())).success


@pytest.fixture
def process(ros):
    return Process(ros)


def test_a_measurement_is_answered_and_obeyed_before_the_driver_goes_on(process, monkeypatch):
    written, ask = [], process.driver._ask

    def count(*given):
        before = len(process.drive.written)
        ask(*given)
        written.append(len(process.drive.written) - before)

    monkeypatch.setattr(process.driver, "_ask", count)
    process.arm()
    process.ros.spin_until(lambda: len(written) > 5)
    assert set(written) == {1}


def test_the_controller_brings_the_carriage_to_the_reference(process):
    process.arm()
    process.ros.spin_until(lambda: abs(process.drive.position - 0.002) < 1e-4)


def test_everybody_hears_each_measurement_and_its_command_once(process):
    process.arm()
    process.ros.spin_until(lambda: len(process.heard[COMMAND]) > 5)
    measured, commanded = process.heard[MEASUREMENT], process.heard[COMMAND]
    assert len(set(commanded)) == len(commanded)
    assert commanded == measured[: len(commanded)]
    assert process.driver._health().values["rejected_messages"] == 0


def test_the_driver_hears_others_and_the_controller_its_driver_alone(process):
    process.ros.spin_until(lambda: process.listener.count_subscribers("/command") == 2)
    assert process.listener.count_subscribers("/measurement") == 1, "the listener's own"


def test_the_controller_lives_in_wall_time_and_leaves_real_time_to_the_driver(ros):
    process = Process(ros, use_sim_time=True, real_time__priority=40, real_time__lock_memory=True)
    for name, value in (("use_sim_time", False), ("real_time.priority", 0)):
        assert process.controller.get_parameter(name).value == value
    assert process.controller.get_parameter("real_time.lock_memory").value is False


def test_a_parameter_file_has_to_be_for_one_of_both(tmp_path):
    path = tmp_path / "file.yaml"
    path.write_text("plant: {ros__parameters: {control_rate: 100.0}}\n")
    file = ("--params-file", str(path))
    process = start_driver(DRIVER, folder=tmp_path, module=MODULE, arguments=file)
    output, errors = process.communicate(timeout=DEADLINE)
    assert (process.returncode, output) == (2, "")
    assert errors == (
        f"error: parameter file {path}: holds nothing for /controller or /driver, its sections "
        "are plant; a section /**/controller or /**/driver is for this node in any namespace\n"
    )


def test_a_signal_stops_and_closes_the_drive(tmp_path):
    log = tmp_path / "calls"
    parameters = (DRIVER, f"driver:drive.log:={log}")
    process = start_driver(*parameters, folder=tmp_path, module=MODULE)
    wait_until_read(process, log)
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=DEADLINE)
    assert (process.returncode, output, errors) == (0, "", "")
    assert log.read_text(encoding="utf-8").split()[-2:] == ["stop", "close"]
