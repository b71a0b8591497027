"""The controller node answers measurements and can be reconfigured while it runs."""

import itertools
import math
import os
from functools import partial

import pytest
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from bdt_controller.controller import ControllerSettings, DeadZoneController
from bdt_controller.controller_node import ControllerNode
from bdt_controller.notch import NotchFilter
from bdt_controller.pid import PidGains
from bdt_controller.reference import ReferenceProfile, reference_at
from bdt_msgs_py.node_parameters import ConfigurationError
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import read_position, read_voltage
from bdt_msgs_py.time_sequence import SILENCE
from bdt_msgs_py.topics import CLOCK, COMMAND, MEASUREMENT, PLATFORM_JOINT, REFERENCE
from bdt_msgs_py.writing import motor_voltage, platform_position, stamp_from_nanoseconds

PERIOD = 2_000_000
SETTINGS = ControllerSettings()


class Bench:
    """A controller with a node that plays the plant."""

    def __init__(self, ros, *, publishers=1, **parameters):
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
        ros.spin_until(lambda: self.node.count_publishers(COMMAND.name) == publishers)
        ros.spin_until(self.client.services_are_ready)

    def measure(self, stamp, position):
        before = len(self.commands)
        self.measurement.publish(platform_position(stamp, position))
        self.ros.spin_until(lambda: len(self.commands) > before)
        return self.commands[-1]

    @property
    def health(self):
        return self.controller._health().values

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


@pytest.mark.parametrize(("simulated", "level"), [(True, 0.0), (False, 5e-3)])
def test_a_controller_that_comes_late_goes_on_with_the_reference_of_simulated_time(
    ros, simulated, level
):
    """Started anew it does not start the reference anew; wall time has no other beginning."""
    bench = Bench(ros, use_sim_time=simulated, reference__step_time=10.0)
    bench.measure(13_000_000_000, 0.0)
    ros.spin_until(lambda: bench.references)
    assert bench.references == [(13_000_000_000, level)]
    assert bench.health["reference_began_s"] == (0.0 if simulated else 13.0)


def test_strays_that_answer_no_measurement_keep_no_controller_from_its_work(ros):
    stranger = ros.create(Node, "stranger")
    publisher = stranger.create_publisher(JointState, COMMAND.name, qos_profile(COMMAND))
    stranger.create_timer(0.05, lambda: publisher.publish(motor_voltage(7, 1.0)))
    bench = Bench(ros, publishers=2)

    def answered():
        bench.measurement.publish(platform_position(0, 0.0))
        return any(stamp == 0 for stamp, _ in bench.commands)

    ros.spin_until(answered)


def test_simulated_time_without_a_clock_is_told(ros):
    bench = Bench(ros, use_sim_time=True)
    wall = 1_795_000_000_000_000_000
    for number in range(15):
        bench.measure(wall + number * 90_000_000, 0.0)
    health = bench.controller._health()
    assert not health.ok
    assert "use_sim_time is true and nobody publishes /clock" in health.summary


def test_time_that_goes_back_for_good_starts_a_new_run(ros):
    bench = Bench(ros)
    _, first = bench.measure(0, 0.0)
    for step in range(1, 100):
        bench.measure(step * PERIOD, 1e-5 * step)
    for step in itertools.count():
        bench.measurement.publish(platform_position(step * PERIOD, 0.0))
        ros.spin_for(SILENCE / 4)
        if len(bench.commands) > 100:
            break
    assert bench.commands[100][1] == first
    assert bench.health["restarts"] == 1


def test_a_plant_that_sends_its_first_measurement_again_and_again_starts_a_new_run(ros):
    """As a plant in lockstep does that was started anew."""
    bench = Bench(ros)
    first = bench.measure(0, 0.0)
    for step in range(1, 100):
        bench.measure(step * PERIOD, 1e-5 * step)

    def answered():
        bench.measurement.publish(platform_position(0, 0.0))
        return len(bench.commands) > 100

    ros.spin_until(answered)
    assert bench.commands[100] == first


def test_with_a_clock_that_went_back_the_first_measurement_starts_a_new_run(ros):
    bench = Bench(ros, use_sim_time=True)
    clock = bench.node.create_publisher(Clock, CLOCK.name, qos_profile(CLOCK))
    ros.spin_until(lambda: clock.get_subscription_count() == 1)

    def tick(nanoseconds):
        def shown():
            clock.publish(Clock(clock=stamp_from_nanoseconds(nanoseconds)))
            return bench.controller.get_clock().now().nanoseconds == nanoseconds

        ros.spin_until(shown)

    tick(10**9)
    first = bench.measure(10**9, 0.0)
    bench.measure(10**9 + PERIOD, 1e-3)
    ros.spin_for(2 * SILENCE)
    tick(0)
    assert bench.measure(0, 0.0) == (0, first[1])
    assert bench.health["restarts"] == 1


@pytest.mark.parametrize("stamp", [10**9, (2**31 - 1) * 10**9])
def test_one_measurement_from_another_time_gets_no_answer_and_changes_nothing(ros, stamp):
    bench = Bench(ros)
    core = DeadZoneController(PidGains(), ControllerSettings())
    for step in range(20):
        position = 1e-4 * step
        if step in {7, 13}:
            bench.measurement.publish(platform_position(stamp, position))
        assert bench.measure(step * PERIOD, position) == (step * PERIOD, core.step(5e-3, position))
    assert len(bench.commands) == 20
    assert bench.health["rejected_messages_by_reason"] == "measurement time: 2"
    assert bench.health["restarts"] == 0


@pytest.mark.parametrize("position", [0.1, -5.0, 999.0])
def test_a_reading_that_the_platform_cannot_have_reached_is_answered_with_the_last_voltage(
    ros, position
):
    bench = Bench(ros)
    core = DeadZoneController(PidGains(), ControllerSettings())
    for step in range(10):
        assert bench.measure(step * PERIOD, 1e-4 * step)[1] == core.step(5e-3, 1e-4 * step)
    held = bench.commands[-1][1]
    assert bench.measure(10 * PERIOD, position) == (10 * PERIOD, held)
    assert bench.measure(11 * PERIOD, 1e-3)[1] == core.step(5e-3, 1e-3)
    assert bench.health["rejected_messages_by_reason"] == "measurement change: 1"


def test_a_reading_that_stays_is_believed_after_a_while(ros):
    bench = Bench(ros, plausibility__confirmations=3)
    bench.measure(0, 0.0)
    core = DeadZoneController(PidGains(), ControllerSettings())
    held = core.step(5e-3, 0.0)
    assert bench.measure(PERIOD, 0.1)[1] == held
    assert bench.measure(2 * PERIOD, 0.1)[1] == held
    assert bench.measure(3 * PERIOD, 0.1)[1] == core.step(5e-3, 0.1)


def test_another_reading_of_the_same_time_is_answered_as_the_first_one_was(ros):
    bench = Bench(ros)
    bench.measure(0, 0.0)
    first = bench.measure(PERIOD, 1e-3)
    assert bench.measure(PERIOD, 1.1e-3) == first
    assert bench.health["rejected_messages_by_reason"] == "measurement repeated: 1"


@pytest.mark.parametrize(
    ("stamp", "position", "reason"),
    [(0, 5.0, "range"), (0, math.nan, "not_finite"), (10**10, 1e-3, "time"), (-1, 1e-3, "stamp")],
)
def test_a_reference_that_cannot_be_meant_is_rejected(ros, stamp, position, reason):
    bench = Bench(ros, reference__kind="topic")
    bench.measure(0, 0.0)
    publisher = bench.node.create_publisher(JointState, REFERENCE.name, qos_profile(REFERENCE))
    publisher.publish(platform_position(stamp, position))
    ros.spin_until(lambda: bench.health["rejected_messages"] == 1)
    assert bench.health["rejected_messages_by_reason"] == f"reference {reason}: 1"
    assert bench.measure(PERIOD, 0.0)[1] == 0.0


@pytest.mark.parametrize("stamp", [-1, -(10**9), -(2**31) * 10**9])
def test_a_clock_before_zero_does_not_end_the_controller(ros, stamp):
    bench = Bench(ros, use_sim_time=True)
    clock = bench.node.create_publisher(Clock, CLOCK.name, qos_profile(CLOCK))
    ros.spin_until(lambda: clock.get_subscription_count() == 1)
    clock.publish(Clock(clock=stamp_from_nanoseconds(stamp)))
    ros.spin_until(lambda: bench.health["rejected_messages_by_reason"] == "clock stamp: 1")


def test_two_controllers_are_noticed_and_named_once(ros):
    bench = Bench(ros)
    assert bench.health["topics_with_several_publishers"] == ""
    ros.create(ControllerNode)
    ros.spin_until(
        lambda: (
            bench.health["topics_with_several_publishers"]
            == "command: /controller, /controller; reference: /controller, /controller"
        )
    )
    health = bench.controller._health()
    assert not health.ok
    assert health.summary == "more than one publisher of command, reference"


def test_a_second_controller_of_a_topic_with_another_name_is_told_apart(ros):
    remapped = ["--ros-args", "-r", "command:=/voltage"]
    first, second = (ros.create(partial(ControllerNode, cli_args=remapped)) for _ in range(2))
    ros.spin_until(lambda: first.count_publishers("/voltage") == 2)
    assert first._command_source() != second._command_source()
    assert second._stand_by.look(0)
    found = first._admission.complete(first._health()).values["topics_with_several_publishers"]
    assert found.startswith("command: /controller, /controller")


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
    core = DeadZoneController(PidGains(), ControllerSettings())
    assert bench.measure(0, 4.9e-3)[1] == core.step(5e-3, 4.9e-3) != 0.0
    assert bench.set("dead_zone_tolerance", 2e-4).successful
    core.configure(PidGains(), ControllerSettings(dead_zone_tolerance=2e-4))
    for step in range(1, 20):
        assert bench.measure(step * PERIOD, 4.9e-3)[1] == core.step(5e-3, 4.9e-3)


def test_gains_filter_offset_and_dead_zone_are_set_in_one_call(ros):
    bench = Bench(ros)
    core = DeadZoneController(PidGains(), ControllerSettings())
    assert bench.measure(0, 1e-3)[1] == core.step(5e-3, 1e-3)
    wanted = {
        "pid.proportional": 6000.0,
        "pid.integral": 12000.0,
        "notch.frequency": 27.0,
        "notch.pole_damping": 0.5,
        "dead_zone_tolerance": 2e-4,
        "voltage_offset": -0.02,
    }
    parameters = [Parameter(name, value=value) for name, value in wanted.items()]
    answer = bench.ros.result(bench.client.set_parameters_atomically(parameters))
    assert answer.result.successful
    settings = ControllerSettings(dead_zone_tolerance=2e-4, voltage_offset=-0.02)
    notch = NotchFilter(27.0, pole_damping=0.5)
    core.configure(PidGains(6000.0, 12000.0), settings, notch)
    for step in range(1, 10):
        position = 1e-3 + 1e-4 * step
        assert bench.measure(step * PERIOD, position)[1] == core.step(5e-3, position)


def test_a_filter_that_is_not_allowed_leaves_all_as_it_was(ros):
    bench = Bench(ros)
    wanted = [Parameter("pid.integral", value=0.0), Parameter("notch.frequency", value=-1.0)]
    answer = bench.ros.result(bench.client.set_parameters_atomically(wanted))
    assert not answer.result.successful
    core = DeadZoneController(PidGains(), ControllerSettings())
    assert bench.measure(0, 1e-3)[1] == core.step(5e-3, 1e-3)


def set_both(bench, tolerance, offset):
    """Set dead zone and offset in one atomic call."""
    both = [
        Parameter("dead_zone_tolerance", value=tolerance),
        Parameter("voltage_offset", value=offset),
    ]
    return bench.ros.result(bench.client.set_parameters_atomically(both)).result


def test_dead_zone_and_voltage_offset_are_set_in_one_call(ros):
    bench = Bench(ros)
    assert set_both(bench, 2e-4, -0.02).successful
    assert bench.measure(0, 4.9e-3)[1] == -0.02
    assert bench.health["voltage_offset_v"] == -0.02


@pytest.mark.parametrize(("tolerance", "offset"), [(2e-4, 2.5), (-1.0, 0.02)])
def test_of_dead_zone_and_voltage_offset_both_are_set_or_neither(ros, tolerance, offset):
    bench = Bench(ros, voltage_limit=2.0)
    assert not set_both(bench, tolerance, offset).successful
    core = DeadZoneController(PidGains(), ControllerSettings(voltage_limit=2.0))
    assert bench.measure(0, 4.9e-3)[1] == core.step(5e-3, 4.9e-3)


def test_the_voltage_offset_is_in_every_command_also_before_the_reference_comes(ros):
    bench = Bench(ros, reference__kind="topic", voltage_offset=-0.02)
    assert bench.measure(0, 1e-3)[1] == -0.02
    assert bench.set("voltage_offset", 0.01).successful
    assert bench.measure(PERIOD, 1e-3)[1] == 0.01


def test_the_motions_of_commissioning_are_those_of_the_core(ros):
    parameters = {"kind": "commissioning", "first": 1e-3, "largest_speed": 0.01}
    bench = Bench(ros, use_sim_time=True, **{f"reference__{k}": v for k, v in parameters.items()})
    profile, core = ReferenceProfile(**parameters), DeadZoneController(PidGains(), SETTINGS)
    for step in range(995, 1060):
        r = reference_at(profile, step * PERIOD * 1e-9)
        assert bench.measure(step * PERIOD, 0.0)[1] == core.step(r, 0.0)
    ros.spin_until(lambda: bench.references[-1] == (1050 * PERIOD, 1e-3))
    assert len({position for _, position in bench.references}) == 51


def test_gains_can_be_set_while_the_controller_runs(ros):
    bench = Bench(ros)
    assert bench.set("pid.proportional", 0.0).successful
    assert bench.set("pid.integral", 0.0).successful
    assert bench.set("pid.derivative", 0.0).successful
    assert bench.measure(0, 0.0)[1] == 0.0


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("voltage_offset", 10.1),
        ("voltage_offset", math.nan),
        ("voltage_offset", 1),
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
    for untouched in ("dead_zone_tolerance", "voltage_offset"):
        assert bench.controller.get_parameter(untouched).value == 0.0


@pytest.mark.parametrize(
    ("parameters", "says"),
    [
        ({"dead_zone_tolerance": -1.0}, "dead_zone_tolerance = -1.0: must be a number"),
        ({"dead_zone_tolerance": math.nan}, "dead_zone_tolerance = nan"),
        ({"dead_zone_tolerance": 1}, "dead_zone_tolerance = 1: must be a number like 1.0"),
        ({"pid__integral": "big"}, "pid.integral = 'big': must be a number"),
        ({"pid__integrall": 1.0}, "pid.integrall = 1.0: is not a parameter of /controller"),
        ({"reference__kind": "sine"}, "must be one of square, table, commissioning, topic"),
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


def test_garbage_waits_until_the_command_is_out(ros, monkeypatch):
    bench = Bench(ros)
    done = []
    monkeypatch.setattr(bench.controller._command_publisher, "publish", done.append)
    monkeypatch.setattr(bench.controller._process, "use_slack", lambda: done.append("slack"))
    bench.measurement.publish(platform_position(0, 0.0))
    ros.spin_until(lambda: len(done) >= 2)
    assert read_voltage(done[0]) == (0, DeadZoneController(PidGains(), SETTINGS).step(5e-3, 0.0))
    assert done[1:] == ["slack"]


def test_a_priority_that_is_refused_is_a_warning_and_the_controller_controls(ros, monkeypatch):
    def refuse(*_):
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    bench = Bench(ros, real_time__priority=50)
    bench.measure(0, 0.0)
    health = bench.controller._health()
    assert not health.ok
    assert "real_time.priority = 50: refused" in health.summary
