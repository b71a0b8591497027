"""The plant node in lockstep and in real time, against a bench that plays the other nodes."""

import math
import time

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, TimeReference
from std_msgs.msg import Float64MultiArray

from bdt_msgs_py.command_errors import LoopError
from bdt_msgs_py.node_parameters import ConfigurationError
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_stamp, read_position, read_samples
from bdt_msgs_py.topics import (
    CLOCK,
    COMMAND,
    DIAGNOSTICS,
    MEASUREMENT,
    PLATFORM_JOINT,
    PROGRESS,
    TELEMETRY,
    TELEMETRY_COLUMNS,
    TRUTH,
    TRUTH_COLUMNS,
)
from bdt_msgs_py.writing import motor_voltage, platform_position, progress
from bdt_plant.actuator import ActuatorParameters
from bdt_plant.gap_profile import GapProfile
from bdt_plant.motor import MotorParameters
from bdt_plant.plant import PlantModel, Sampling
from bdt_plant.plant_node import PATIENCE, PlantNode
from bdt_plant.plant_simulator import PlantSimulator
from bdt_plant.sensor import SensorParameters

PERIOD = 2_000_000


class Bench:
    """A plant with a node that listens to everything and sends commands."""

    def __init__(self, ros, **parameters):
        self.ros = ros
        self.node = ros.create(Node, "bench")
        self.measurements, self.clock = [], []
        self.telemetry, self.truth = [], []
        self.command = self.node.create_publisher(JointState, COMMAND.name, qos_profile(COMMAND))
        self.progress = self.node.create_publisher(
            TimeReference, PROGRESS.name, qos_profile(PROGRESS)
        )
        self._listen(
            JointState, MEASUREMENT, self.measurements, lambda m: read_position(m, PLATFORM_JOINT)
        )
        self._listen(Clock, CLOCK, self.clock, lambda m: nanoseconds_from_stamp(m.clock))
        self._listen(
            Float64MultiArray,
            TELEMETRY,
            self.telemetry,
            lambda m: read_samples(m, TELEMETRY_COLUMNS).copy(),
        )
        self._listen(
            Float64MultiArray, TRUTH, self.truth, lambda m: read_samples(m, TRUTH_COLUMNS).copy()
        )
        self.plant = ros.create(PlantNode, **parameters)
        ros.spin_until(lambda: self.command.get_subscription_count() == 1)

    @property
    def health(self):
        return self.plant._health().values

    def _listen(self, kind, topic, received, read):
        self.node.create_subscription(
            kind, topic.name, lambda message: received.append(read(message)), qos_profile(topic)
        )

    def answer(self, voltage):
        """Answer the newest measurement and wait for the next one."""
        before = len(self.measurements)
        self.command.publish(motor_voltage(self.measurements[-1][0], voltage))
        self.ros.spin_until(lambda: len(self.measurements) > before)


def test_in_lockstep_the_plant_publishes_what_its_core_computes(ros):
    bench = Bench(ros, telemetry_period=0.01)
    core = PlantSimulator(PlantModel(), GapProfile(), Sampling())
    ros.spin_until(lambda: bench.measurements)
    rows, truth = [], []
    for step in range(25):
        voltage = 10.0 * math.sin(step)
        assert bench.measurements[-1] == (step * PERIOD, core.position)
        truth.append(core.truth())
        rows.append(core.advance(voltage))
        bench.answer(voltage)
    ros.spin_until(lambda: len(bench.telemetry) == 5 and len(bench.truth) == 5)
    np.testing.assert_array_equal(np.concatenate(bench.telemetry), np.concatenate(rows))
    np.testing.assert_array_equal(np.concatenate(bench.truth), np.array(truth))


def test_an_imperfect_plant_publishes_what_its_core_measures_and_counts_what_went_wrong(ros):
    bench = Bench(
        ros,
        telemetry_period=0.01,
        sensor__noise=1e-6,
        sensor__quantization=1e-7,
        sensor__delay=1e-3,
        sensor__drop_probability=0.2,
        sensor__seed=7,
        actuator__saturation=True,
        actuator__voltage_limit=8.0,
        motor__coulomb_friction=0.02,
        motor__viscous_friction=1e-4,
    )
    core = PlantSimulator(
        PlantModel(MotorParameters(coulomb_friction=0.02, viscous_friction=1e-4)),
        GapProfile(),
        Sampling(),
        SensorParameters(1e-6, 1e-7, 1e-3, 0.2, 7),
        ActuatorParameters(saturation=True, voltage_limit=8.0),
    )
    ros.spin_until(lambda: bench.measurements)
    rows, truth = [], []
    for step in range(25):
        voltage = 10.0 * math.sin(step)
        assert bench.measurements[-1] == (step * PERIOD, core.position)
        truth.append(core.truth())
        rows.append(core.advance(voltage))
        bench.answer(voltage)
    ros.spin_until(lambda: len(bench.telemetry) == 5 and len(bench.truth) == 5)
    np.testing.assert_array_equal(np.concatenate(bench.telemetry), np.concatenate(rows))
    np.testing.assert_array_equal(np.concatenate(bench.truth), np.array(truth))
    health = bench.plant._health()
    beyond = sum(abs(10.0 * math.sin(step)) > 8.0 for step in range(25))
    assert health.values["saturated_steps"] == core.saturated_steps == beyond
    assert health.values["dropped_samples"] == core.dropped_samples > 0


def test_in_lockstep_nothing_moves_without_the_command_for_the_newest_measurement(ros):
    bench = Bench(ros, resend_period=0.05)
    ros.spin_until(lambda: bench.measurements)
    bench.answer(1.0)
    ros.spin_until(lambda: bench.measurements[-1][0] == PERIOD)
    bench.command.publish(motor_voltage(0, 5.0))
    bench.command.publish(motor_voltage(7 * PERIOD, 5.0))
    before = len(bench.measurements)
    ros.spin_until(lambda: len(bench.measurements) >= before + 3)
    assert {stamp for stamp, _ in bench.measurements[before:]} == {PERIOD}


@pytest.mark.parametrize(
    "message", [motor_voltage(0, math.nan), motor_voltage(0, math.inf), platform_position(0, 1.0)]
)
def test_a_command_that_is_not_a_finite_voltage_is_rejected_and_counted(ros, message):
    bench = Bench(ros)
    ros.spin_until(lambda: bench.measurements)
    bench.command.publish(message)
    ros.spin_until(lambda: bench.plant._health().values["rejected_messages"] == 1)
    bench.answer(0.0)
    assert bench.measurements[-1] == (PERIOD, 0.0)


@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
@pytest.mark.parametrize("stamp", [-1, 1, PERIOD // 2, 10**9, (2**31 - 1) * 10**9])
def test_a_command_that_answers_no_measurement_moves_nothing(ros, mode, stamp):
    bench = Bench(ros, mode=mode, telemetry_period=0.01, control_rate=100.0, sampling_rate=1000.0)
    ros.spin_until(lambda: bench.measurements)
    bench.command.publish(motor_voltage(stamp, 24.0))
    ros.spin_until(lambda: bench.health["rejected_messages"] == 1)
    reason = "stamp" if stamp < 0 else "time"
    assert bench.health["rejected_messages_by_reason"] == f"command {reason}: 1"
    if mode == "realtime":
        ros.spin_until(lambda: len(bench.telemetry) > 20)
        assert not np.concatenate(bench.telemetry)[:, 1].any()


def test_voltages_beyond_the_hardware_s_limit_are_limited_and_counted(ros):
    bench = Bench(ros, limits__voltage=10.0, telemetry_period=0.002)
    ros.spin_until(lambda: bench.measurements)
    for voltage in (9.0, 11.0, -1e300):
        bench.answer(voltage)
    ros.spin_until(lambda: len(bench.telemetry) == 3)
    assert [rows[0, 1] for rows in bench.telemetry] == [9.0, 10.0, -10.0]
    health = bench.plant._health()
    assert (health.ok, health.values["limited_steps"]) == (False, 2)
    assert health.summary == "commands missing, late or beyond the voltage limit"


def test_beyond_its_travel_the_motor_gets_no_voltage_and_the_diagnostics_say_error(ros):
    bench = Bench(ros, limits__position=1e-4, telemetry_period=0.002)
    statuses = []
    bench.node.create_subscription(
        DiagnosticArray,
        DIAGNOSTICS.name,
        lambda message: statuses.extend(message.status),
        qos_profile(DIAGNOSTICS),
    )
    ros.spin_until(lambda: bench.measurements)
    while abs(bench.measurements[-1][1]) <= 1e-4:
        bench.answer(40.0)
    for _ in range(5):
        bench.answer(40.0)
    ros.spin_until(lambda: len(bench.telemetry) == len(bench.measurements) - 1)
    rows = np.concatenate(bench.telemetry)[::10]
    assert set(rows[np.abs(rows[:, 2]) > 1e-4, 1]) == {0.0}
    assert set(rows[np.abs(rows[:, 2]) <= 1e-4, 1]) == {40.0}
    ros.spin_until(lambda: any(one.level == DiagnosticStatus.ERROR for one in statuses))
    assert "position beyond 0.0001 m: the motor gets 0 V" in statuses[-1].message


def test_commands_are_taken_from_one_source_until_it_is_silent(ros):
    bench = Bench(ros, command_timeout=0.5)
    ros.spin_until(lambda: bench.measurements)
    before = len(bench.measurements)
    bench.command.publish(motor_voltage(0, 1.0, "/controller"))
    ros.spin_until(lambda: len(bench.measurements) > before)
    bench.command.publish(motor_voltage(PERIOD, 24.0, "/somebody"))
    ros.spin_until(lambda: bench.health["rejected_messages_by_reason"] == "command source: 1")

    def taken_over():
        bench.command.publish(motor_voltage(PERIOD, 2.0, "/somebody"))
        return bench.measurements[-1][0] > PERIOD

    ros.spin_until(taken_over)


def test_a_forged_answer_drives_the_motor_for_one_period_within_the_limits(ros):
    """In the controller's name and in time it cannot be told from the controller's own."""
    bench = Bench(ros, limits__voltage=24.0, telemetry_period=0.002)
    ros.spin_until(lambda: bench.measurements)
    for voltage in (0.0, 1e300, 0.0):
        bench.answer(voltage)
    ros.spin_until(lambda: len(bench.telemetry) == 3)
    assert [rows[0, 1] for rows in bench.telemetry] == [0.0, 24.0, 0.0]


def test_another_publisher_of_a_plant_s_topics_is_noticed_and_named(ros):
    bench = Bench(ros)
    other = ros.create(Node, "other")
    other.create_publisher(JointState, MEASUREMENT.name, qos_profile(MEASUREMENT))
    ros.spin_until(
        lambda: bench.health["topics_with_several_publishers"] == "measurement: /other, /plant"
    )
    assert bench.plant._health().summary == "more than one publisher of measurement"


def test_the_plant_owns_the_clock(ros):
    plant = ros.create(PlantNode)
    result = plant.set_parameters([Parameter("use_sim_time", value=True)])[0]
    assert not result.successful
    assert result.reason == "use_sim_time cannot be set while plant runs: the plant owns the clock"
    assert not plant.get_parameter("use_sim_time").value
    assert plant.set_parameters([Parameter("use_sim_time", value=False)])[0].successful


def bench_with_followers(ros, followers, timeout):
    """Return a bench whose followers wait for the first telemetry, after the first command."""
    for number in range(1, len(followers)):
        # The plant begins once there is a listener for each of them.
        ros.create(Node, f"listener_{number}").create_subscription(
            Float64MultiArray, TELEMETRY.name, lambda _: None, qos_profile(TELEMETRY)
        )
    bench = Bench(
        ros,
        lockstep_followers=followers,
        telemetry_period=0.002,
        lockstep_timeout=timeout,
        resend_period=0.05,
    )
    for name in followers:
        bench.progress.publish(progress(name, 0, None))
    ros.spin_until(lambda: bench.measurements)
    bench.command.publish(motor_voltage(0, 0.0))
    return bench


@pytest.mark.parametrize("silent", ["twin", "recorder"])
def test_the_follower_that_is_silent_is_named_whatever_the_other_one_says(ros, silent):
    (other,) = {"twin", "recorder"} - {silent}
    bench = bench_with_followers(ros, ["twin", "recorder"], 1.0)
    alive = bench.node.create_timer(
        0.05, lambda: bench.progress.publish(progress(other, 1_800_000, None))
    )
    with pytest.raises(LoopError, match=f"for progress of {silent} at t = 0.002 s"):
        ros.result(bench.plant.finished)
    alive.cancel()


def test_a_follower_that_speaks_and_does_not_come_on_ends_the_run(ros):
    bench = bench_with_followers(ros, ["twin"], 1.0)
    alive = bench.node.create_timer(
        0.05, lambda: bench.progress.publish(progress("twin", 0, 1_000_000))
    )
    with pytest.raises(LoopError, match=r"for progress of twin at t = 0\.002 s"):
        ros.result(bench.plant.finished)
    alive.cancel()


def test_a_follower_that_is_slow_and_comes_on_is_awaited(ros):
    bench = bench_with_followers(ros, ["twin"], 2.0)
    ros.spin_until(lambda: bench.telemetry)
    said = []

    def come_on():
        said.append(len(said) + 1)
        bench.progress.publish(progress("twin", 100_000 * said[-1], None))

    slow = bench.node.create_timer(0.15, come_on)
    ros.spin_until(lambda: bench.measurements[-1][0] == PERIOD or bench.plant.finished.done())
    slow.cancel()
    assert len(said) >= 18, "it took longer than the timeout"
    assert not bench.plant.finished.done()


def test_a_follower_that_has_not_got_the_newest_telemetry_gets_it_again(ros):
    bench = bench_with_followers(ros, ["twin", "recorder"], 10.0)
    began = time.monotonic()
    ros.spin_until(lambda: bench.telemetry)
    # A recorder that has it all is no reason, a twin that has not is one.
    bench.progress.publish(progress("recorder", 1_800_000, None))
    ros.spin_until(lambda: len(bench.telemetry) == 3)
    assert time.monotonic() - began >= 2.0 * PATIENCE - 0.1
    assert (bench.telemetry[1] == bench.telemetry[0]).all()
    assert len(bench.truth) == 1
    assert bench.health["resent_batches"] == 2
    bench.progress.publish(progress("twin", 1_800_000, None))
    ros.spin_until(lambda: bench.measurements[-1][0] == PERIOD)
    ros.spin_for(PATIENCE + 0.2)
    assert len(bench.telemetry) == 3


def test_the_last_telemetry_of_a_run_is_sent_again_too(ros):
    bench = Bench(
        ros,
        lockstep_followers=["friend"],
        duration=0.004,
        telemetry_period=0.004,
        lockstep_timeout=10.0,
        resend_period=0.05,
    )
    bench.progress.publish(progress("friend", 0, None))
    ros.spin_until(lambda: bench.measurements)
    bench.answer(0.0)
    bench.command.publish(motor_voltage(PERIOD, 0.0))
    ros.spin_until(lambda: len(bench.telemetry) == 2)
    bench.progress.publish(progress("friend", round(bench.telemetry[-1][-1, 0] * 1e9), None))
    ros.spin_until(bench.plant.finished.done)


def test_progress_from_the_past_does_not_hold_the_plant(ros):
    bench = Bench(ros, lockstep_followers=["friend"], telemetry_period=0.002, resend_period=0.05)
    bench.progress.publish(progress("friend", 0, None))
    ros.spin_until(lambda: bench.measurements)
    bench.command.publish(motor_voltage(0, 0.0))
    ros.spin_until(lambda: bench.telemetry)
    bench.progress.publish(progress("friend", 1_800_000, None))
    ros.spin_until(lambda: bench.measurements[-1][0] == PERIOD)
    bench.progress.publish(progress("friend", 0, 0))
    ros.spin_until(lambda: bench.health["rejected_messages_by_reason"] == "progress time: 1")
    bench.answer(0.0)


def test_the_plant_ends_when_its_duration_is_over(ros):
    bench = Bench(ros, duration=0.01, telemetry_period=0.004)
    ros.spin_until(lambda: bench.measurements)
    for _ in range(4):
        bench.answer(1.0)
    bench.command.publish(motor_voltage(bench.measurements[-1][0], 1.0))
    ros.result(bench.plant.finished)
    ros.spin_until(lambda: len(bench.telemetry) == 3)
    times = np.concatenate(bench.telemetry)[:, 0]
    np.testing.assert_array_equal(times, np.arange(50) / 5000)


def test_a_controller_that_dies_in_lockstep_becomes_an_error_that_says_so(ros):
    bench = Bench(ros, lockstep_timeout=1.0, resend_period=0.05)
    ros.spin_until(lambda: bench.measurements)
    bench.answer(1.0)
    with pytest.raises(LoopError, match=r"/plant waited .* s for a command at t = 0.002 s"):
        ros.result(bench.plant.finished)


def test_a_plant_waits_for_its_controller_as_long_as_it_takes(ros):
    plant = ros.create(PlantNode, lockstep_timeout=0.1, resend_period=0.02)
    ros.spin_for(0.5)
    assert not plant.finished.done()


def test_a_follower_holds_the_plant_until_it_has_the_telemetry_and_has_acted(ros):
    bench = Bench(ros, lockstep_followers=["friend"], telemetry_period=0.004, resend_period=0.05)
    ros.spin_for(0.3)
    assert not bench.measurements

    def tell(telemetry_end, earliest_action):
        bench.progress.publish(progress("friend", telemetry_end, earliest_action))

    tell(0, None)
    ros.spin_until(lambda: bench.measurements)
    bench.answer(0.0)
    bench.command.publish(motor_voltage(PERIOD, 0.0))
    ros.spin_until(lambda: bench.telemetry)
    count = len(bench.measurements)
    ros.spin_for(0.3)
    assert len(bench.measurements) == count
    newest = round(bench.telemetry[-1][-1, 0] * 1e9)
    tell(newest, 2 * PERIOD)
    ros.spin_for(0.3)
    assert len(bench.measurements) == count
    assert bench.clock[-1] == 2 * PERIOD
    tell(newest, 2 * PERIOD + 1)
    ros.spin_until(lambda: bench.measurements[-1][0] == 2 * PERIOD)


def test_a_follower_that_dies_is_named(ros):
    bench = Bench(
        ros,
        lockstep_followers=["friend"],
        telemetry_period=0.002,
        lockstep_timeout=1.0,
        resend_period=0.05,
    )
    bench.progress.publish(progress("friend", 0, None))
    ros.spin_until(lambda: bench.measurements)
    bench.command.publish(motor_voltage(0, 0.0))
    with pytest.raises(LoopError, match="for progress of friend"):
        ros.result(bench.plant.finished)


def test_in_real_time_the_plant_keeps_the_pace_of_the_wall_clock(ros):
    begin = time.monotonic()
    bench = Bench(ros, mode="realtime", duration=0.5, control_rate=100.0, sampling_rate=1000.0)
    ros.result(bench.plant.finished)
    assert time.monotonic() - begin >= 0.5
    ros.spin_until(lambda: bench.telemetry and bench.telemetry[-1][-1, 0] == 0.499)


def test_in_real_time_a_voltage_without_fresh_commands_becomes_zero(ros):
    bench = Bench(
        ros,
        mode="realtime",
        control_rate=100.0,
        sampling_rate=1000.0,
        command_timeout=0.1,
        telemetry_period=0.05,
    )
    ros.spin_until(lambda: bench.measurements)

    def driven():
        # On a busy machine a command may be stale before the next step.
        bench.command.publish(motor_voltage(bench.measurements[-1][0], 3.0))
        return any(rows[:, 1].any() for rows in bench.telemetry)

    ros.spin_until(driven)
    last_command = bench.plant._simulator.time
    ros.spin_until(lambda: bench.plant._simulator.time > last_command + 0.5)
    time, voltage, _ = np.concatenate(bench.telemetry).T
    assert set(voltage) == {0.0, 3.0}
    assert time[voltage > 0.0].max() < last_command + 0.15
    assert bench.plant._health().values["steps_without_fresh_command"] > 10


@pytest.mark.parametrize(
    ("parameters", "says"),
    [
        ({"mode": "warp"}, "mode = 'warp': must be one of lockstep, realtime"),
        ({"control_rate": 300.0}, "control_rate = 300.0 Hz: must divide sampling_rate (5000 Hz)"),
        ({"motor__inductance": 0.0}, "motor.inductance = 0.0: must be"),
        ({"gap__final": math.nan}, "gap.final = nan"),
        ({"gap__final": -0.1}, "gap.final = -0.1"),
        ({"gap__table_times": [0.0, 2.0, 1.0]}, "table_gaps has 2 values"),
        ({"gap__knd": "ramp"}, "gap.knd = 'ramp': is not a parameter of /plant"),
        ({"sensor__drop_probability": 1.5}, "sensor.drop_probability = 1.5: must be"),
        ({"actuator__voltage_limit": 0.0}, "actuator.voltage_limit = 0.0: must be"),
        ({"structure__mass": "heavy"}, "structure.mass = 'heavy': must be a number"),
    ],
)
def test_a_start_with_bad_parameters_names_parameter_value_and_what_is_allowed(
    ros, parameters, says
):
    watcher = ros.create(Node, "watcher")
    with pytest.raises(ConfigurationError) as caught:
        ros.create(PlantNode, **parameters)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)
    ros.spin_until(lambda: watcher.get_node_names() == ["watcher"])


def set_parameters(bench, **values):
    changes = [Parameter(name.replace("__", "."), value=value) for name, value in values.items()]
    return bench.plant.set_parameters_atomically(changes)


def test_gap_friction_and_noise_change_while_the_plant_runs(ros):
    bench = Bench(ros, telemetry_period=0.002, gap__kind="constant")
    core = PlantSimulator(PlantModel(), GapProfile("constant"), Sampling())
    ros.spin_until(lambda: bench.measurements)
    bench.answer(5.0)
    core.advance(5.0)
    assert set_parameters(
        bench, gap__initial=0.2, motor__coulomb_friction=0.01, sensor__noise=1e-6
    ).successful
    core.reconfigure(
        PlantModel(MotorParameters(coulomb_friction=0.01)),
        GapProfile("constant", 0.2),
        SensorParameters(noise=1e-6),
    )
    rows, truth = [], core.truth()
    for _ in range(3):
        rows.append(core.advance(-5.0))
        bench.answer(-5.0)
    ros.spin_until(lambda: len(bench.telemetry) == 4 and len(bench.truth) == 4)
    np.testing.assert_array_equal(np.concatenate(bench.telemetry[1:]), np.concatenate(rows))
    np.testing.assert_array_equal(bench.truth[1], [truth])
    assert truth[3] == 0.2


def test_a_mechanism_does_not_become_one_of_another_kind(ros):
    bench = Bench(ros, motor__coulomb_friction=0.01, motor__static_friction=0.02)
    answer = set_parameters(bench, motor__coulomb_friction=0.02)
    assert not answer.successful
    assert "cannot go on" in answer.reason


def test_a_pause_holds_the_plant_and_a_later_one_lets_it_go_on(ros):
    bench = Bench(ros, pause_at=0.004, lockstep_timeout=0.1, resend_period=0.05)
    ros.spin_until(lambda: bench.measurements)
    bench.answer(0.0)
    bench.command.publish(motor_voltage(bench.measurements[-1][0], 0.0))
    ros.spin_for(0.4)
    assert [stamp for stamp, _ in bench.measurements] == [0, PERIOD]
    assert not bench.plant.finished.done()
    assert set_parameters(bench, pause_at=0.006).successful
    ros.spin_until(lambda: bench.measurements[-1][0] == 2 * PERIOD)


def test_a_paced_plant_keeps_to_the_wall_clock(ros):
    bench = Bench(ros, pace=0.1)
    ros.spin_until(lambda: bench.measurements)
    begin = time.monotonic()
    for _ in range(10):
        bench.answer(0.0)
    assert time.monotonic() - begin >= 9 * 0.02


def test_real_time_has_no_other_pace(ros):
    bench = Bench(ros, mode="realtime")
    answer = set_parameters(bench, pace=2.0)
    assert not answer.successful
    assert "lockstep" in answer.reason
