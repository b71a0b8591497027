"""The controller node answers measurements and can be reconfigured while it runs."""

import math

import pytest
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from sensor_msgs.msg import JointState

from bdt_controller.controller import ControllerSettings, DeadZoneController
from bdt_controller.controller_node import ControllerNode
from bdt_controller.pid import PidGains
from bdt_msgs_py.node_parameters import ConfigurationError
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import read_position, read_voltage
from bdt_msgs_py.topics import COMMAND, MEASUREMENT, PLATFORM_JOINT, REFERENCE
from bdt_msgs_py.writing import motor_voltage, platform_position

PERIOD = 2_000_000


class Bench:
    """A controller with a node that plays the plant."""

    def __init__(self, ros, **parameters):
        self.ros = ros
        self.controller = ros.create(ControllerNode, **parameters)
        self.node = ros.create(Node, "bench")
        self.commands = []
        self.references = []
        self.measurement = self.node.create_publisher(
            JointState, MEASUREMENT.name, qos_profile(MEASUREMENT)
        )
        self.node.create_subscription(
            JointState,
            COMMAND.name,
            lambda message: self.commands.append(read_voltage(message)),
            qos_profile(COMMAND),
        )
        if self.controller.get_parameter("reference.kind").value != "topic":
            self.node.create_subscription(
                JointState,
                REFERENCE.name,
                lambda message: self.references.append(read_position(message, PLATFORM_JOINT)),
                qos_profile(REFERENCE),
            )
        self.client = AsyncParameterClient(self.node, "controller")
        ros.spin_until(lambda: self.measurement.get_subscription_count() == 1)
        ros.spin_until(lambda: self.node.count_publishers(COMMAND.name) == 1)
        ros.spin_until(self.client.services_are_ready)

    def measure(self, stamp, position):
        before = len(self.commands)
        self.measurement.publish(platform_position(stamp, position))
        self.ros.spin_until(lambda: len(self.commands) > before)
        return self.commands[-1]

    def set(self, name, value):
        (result,) = self.ros.result(
            self.client.set_parameters([Parameter(name, value=value)])
        ).results
        return result


def test_every_measurement_is_answered_with_its_own_stamp_and_the_core_s_voltage(ros):
    bench = Bench(ros)
    core = DeadZoneController(PidGains(), ControllerSettings())
    for step in range(50):
        position = 1e-4 * step
        assert bench.measure(step * PERIOD, position) == (
            step * PERIOD,
            core.step(5e-3, position),
        )


def test_no_command_is_beyond_the_voltage_limit(ros):
    bench = Bench(ros, voltage_limit=2.0)
    core = DeadZoneController(PidGains(), ControllerSettings(voltage_limit=2.0))
    commands = []
    for step in range(20):
        _, voltage = bench.measure(step * PERIOD, 1e-4 * step)
        assert voltage == core.step(5e-3, 1e-4 * step)
        commands.append(abs(voltage))
    assert max(commands) == 2.0


def test_a_repeated_measurement_gets_the_same_answer_and_moves_nothing(ros):
    bench = Bench(ros)
    bench.measure(0, 0.0)
    first = bench.measure(PERIOD, 1e-3)
    assert bench.measure(PERIOD, 1e-3) == first
    fresh = DeadZoneController(PidGains(), ControllerSettings())
    fresh.step(5e-3, 0.0)
    fresh.step(5e-3, 1e-3)
    assert bench.measure(2 * PERIOD, 2e-3)[1] == fresh.step(5e-3, 2e-3)


def test_time_that_goes_back_starts_a_new_run(ros):
    bench = Bench(ros)
    first = bench.measure(0, 0.0)
    for step in range(1, 5):
        bench.measure(step * PERIOD, 1e-3)
    assert bench.measure(0, 0.0) == first


def test_the_reference_is_published_when_it_changes_and_kept_for_late_listeners(ros):
    bench = Bench(ros, reference__step_time=0.01)
    for step in range(11):
        bench.measure(step * PERIOD, 0.0)
    ros.spin_until(lambda: len(bench.references) == 3)
    assert bench.references == [(0, 5e-3), (5 * PERIOD, 0.0), (10 * PERIOD, 5e-3)]
    late = []
    bench.node.create_subscription(
        JointState, REFERENCE.name, lambda m: late.append(m.position[0]), qos_profile(REFERENCE)
    )
    ros.spin_until(lambda: late == [5e-3])


def test_the_reference_may_come_from_a_topic_and_until_then_the_voltage_is_zero(ros):
    bench = Bench(ros, reference__kind="topic")
    assert bench.measure(0, 1e-3)[1] == 0.0
    publisher = bench.node.create_publisher(JointState, REFERENCE.name, qos_profile(REFERENCE))
    publisher.publish(platform_position(0, 2e-3))
    core = DeadZoneController(PidGains(), ControllerSettings())
    ros.spin_until(lambda: bench.controller.count_publishers(REFERENCE.name) == 1)
    stamp = PERIOD
    while bench.measure(stamp, 1e-3)[1] == 0.0:
        stamp += PERIOD
    assert bench.commands[-1][1] == core.step(2e-3, 1e-3)


@pytest.mark.parametrize("position", [math.nan, math.inf])
def test_a_measurement_that_is_not_finite_is_rejected_and_counted(ros, position):
    bench = Bench(ros)
    bench.measurement.publish(platform_position(0, position))
    bench.measurement.publish(motor_voltage(0, 1.0))
    assert bench.measure(PERIOD, 0.0)[0] == PERIOD
    assert bench.controller._health().values["rejected_messages"] == 2
    assert not math.isnan(bench.commands[-1][1])


def test_the_dead_zone_is_set_through_the_standard_parameter_service(ros):
    bench = Bench(ros)
    assert bench.measure(0, 4.9e-3)[1] != 0.0
    assert bench.set("dead_zone_tolerance", 2e-4).successful
    assert bench.measure(PERIOD, 4.9e-3)[1] == 0.0
    assert bench.measure(2 * PERIOD, 4.7e-3)[1] != 0.0


def test_gains_can_be_set_while_the_controller_runs(ros):
    bench = Bench(ros)
    assert bench.set("pid.proportional", 0.0).successful
    assert bench.set("pid.integral", 0.0).successful
    assert bench.set("pid.derivative", 0.0).successful
    assert bench.measure(0, 0.0)[1] == 0.0


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("dead_zone_tolerance", -1e-6),
        ("dead_zone_tolerance", math.nan),
        ("dead_zone_tolerance", math.inf),
        ("dead_zone_tolerance", 1e3),
        ("dead_zone_tolerance", 1),
        ("dead_zone_tolerance", "wide"),
        ("pid.filter_time", 0.0),
        ("control_rate", 100.0),
        ("no_such_parameter", 1.0),
    ],
)
def test_a_parameter_that_is_not_allowed_is_refused_with_a_reason(ros, name, value):
    bench = Bench(ros)
    result = bench.set(name, value)
    assert not result.successful
    assert result.reason
    assert bench.controller.get_parameter("dead_zone_tolerance").value == 0.0


@pytest.mark.parametrize(
    ("parameters", "says"),
    [
        ({"dead_zone_tolerance": -1.0}, "dead_zone_tolerance = -1.0: must be a number"),
        ({"dead_zone_tolerance": math.nan}, "dead_zone_tolerance = nan"),
        ({"dead_zone_tolerance": 1}, "dead_zone_tolerance = 1: must be a number like 1.0"),
        ({"pid__integral": "big"}, "pid.integral = 'big': must be a number"),
        ({"pid__integrall": 1.0}, "pid.integrall = 1.0: is not a parameter of /controller"),
        ({"reference__kind": "sine"}, "must be one of square, table, topic"),
        (
            {"reference__kind": "table", "reference__table_times": [0.0, 0.0]},
            "table_positions has 1 values: must have as many as table_times",
        ),
    ],
)
def test_a_start_with_bad_parameters_names_parameter_value_and_what_is_allowed(
    ros, parameters, says
):
    watcher = ros.create(Node, "watcher")
    with pytest.raises(ConfigurationError) as caught:
        ros.create(ControllerNode, **parameters)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)
    ros.spin_until(lambda: watcher.get_node_names() == ["watcher"])
