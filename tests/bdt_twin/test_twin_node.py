"""The twin node: telemetry in, estimates out, the dead zone of a controller reconfigured."""

import sys
from itertools import pairwise

import numpy as np
import pytest
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, TimeReference
from std_msgs.msg import Float64MultiArray

from bdt_controller.notch import NotchFilter
from bdt_controller.pid import PidGains
from bdt_msgs_py.node_parameters import ConfigurationError
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_stamp, read_position, read_voltage
from bdt_msgs_py.time_sequence import SILENCE
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    CLOCK,
    DEAD_ZONE_JOINT,
    GAP_AGE_JOINT,
    GAP_JOINT,
    PROGRESS,
    TELEMETRY,
    TELEMETRY_COLUMNS,
    VOLTAGE_OFFSET_JOINT,
)
from bdt_msgs_py.writing import sample_message, stamp_from_nanoseconds
from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import PlantModel, Sampling
from bdt_plant.plant_simulator import PlantSimulator
from bdt_twin.decider import create_decider
from bdt_twin.decision import ControllerGains, Decision
from bdt_twin.decision_settings import DecisionSettings
from bdt_twin.estimator import Estimate
from bdt_twin.inverse_filter import InverseFilterEstimator, InverseFilterSettings
from bdt_twin.twin_node import TwinNode

GAP = np.deg2rad(10.0)
BATCH = 500


@pytest.fixture(scope="module")
def telemetry():
    """Three seconds of a motor that goes to and fro with a gap of 10 degrees."""
    plant = PlantSimulator(PlantModel(), GapProfile(kind="constant", initial=GAP), Sampling())
    return np.concatenate(
        [plant.advance(8.0 * np.sin(2 * np.pi * step / 500)) for step in range(1500)]
    )


class Bench:
    """A twin with a node that plays plant and controller."""

    def __init__(self, ros, *, accept=True, controller=True, **parameters):
        self.ros = ros
        self.accept = accept
        self.messages, self.progress = [], []
        self.requests, self.time = [], 0.0
        self.node = ros.create(Node, "bench")
        self.clock = self.node.create_publisher(Clock, CLOCK.name, qos_profile(CLOCK))
        self.telemetry = self.node.create_publisher(
            Float64MultiArray, TELEMETRY.name, qos_profile(TELEMETRY)
        )
        self.node.create_subscription(
            JointState,
            BACKLASH_ESTIMATE.name,
            self.messages.append,
            qos_profile(BACKLASH_ESTIMATE),
        )
        self.node.create_subscription(
            TimeReference, PROGRESS.name, self.progress.append, qos_profile(PROGRESS)
        )
        self.peer = self.start_controller() if controller else None
        self.twin = ros.create(TwinNode, use_sim_time=True, **parameters)
        ros.spin_until(lambda: self.telemetry.get_subscription_count() == 1)
        ros.spin_until(lambda: self.clock.get_subscription_count() == 1)
        ros.spin_until(lambda: self.node.count_publishers(BACKLASH_ESTIMATE.name) == 1)

    def start_controller(self):
        peer = self.ros.create(Node, "controller")
        peer.declare_parameter("dead_zone_tolerance", 0.0, ParameterDescriptor())
        peer.add_on_set_parameters_callback(self._decide)
        return peer

    def _decide(self, parameters):
        self.requests.append((self.time, parameters[0].value))
        return SetParametersResult(successful=self.accept, reason="" if self.accept else "no")

    def tick(self, time):
        """Let simulated time reach `time` [s]."""
        self.time = time
        self.clock.publish(Clock(clock=stamp_from_nanoseconds(round(time * 1e9))))
        self.ros.spin_until(lambda: self.twin.get_clock().now().nanoseconds == round(time * 1e9))

    def send(self, rows):
        taken = self.health["telemetry_accepted"] + self.health["rejected_messages"]
        self.telemetry.publish(sample_message(rows, TELEMETRY_COLUMNS))
        self.ros.spin_until(
            lambda: self.health["telemetry_accepted"] + self.health["rejected_messages"] > taken
        )

    def run(self, rows):
        """Send batches with the clock beside them."""
        for start in range(0, len(rows), BATCH):
            batch = rows[start : start + BATCH]
            self.tick(round(batch[-1, 0] + 2e-4, 4))
            self.send(batch)

    def wait_for_progress(self, telemetry_end):
        """Wait until the twin has worked on the telemetry up to a stamp [ns]."""
        self.ros.spin_until(
            lambda: (
                self.progress
                and nanoseconds_from_stamp(self.progress[-1].header.stamp) == telemetry_end
            )
        )

    @property
    def estimates(self):
        """Stamps [ns] and gaps [rad] of the estimates so far."""
        return [read_position(message, GAP_JOINT) for message in self.messages]

    @property
    def health(self):
        return self.twin._health().values


def test_the_twin_publishes_what_its_estimator_computes(ros, telemetry):
    bench = Bench(ros)
    bench.run(telemetry)
    core = InverseFilterEstimator(PlantModel(), InverseFilterSettings())
    expected = [
        (round(estimate.sample * 1e9 / 5000), estimate.gap)
        for estimate in core.estimates(telemetry[:, 1], telemetry[:, 2])
    ]
    ros.spin_until(lambda: len(bench.estimates) >= len(expected))
    assert bench.estimates == expected
    assert abs(bench.estimates[-1][1] - GAP) < np.deg2rad(0.15)


def test_the_dead_zone_changes_when_the_communication_delay_is_over_not_before(ros, telemetry):
    bench = Bench(ros, communication_delay=1.0)
    bench.run(telemetry)
    first_estimate = bench.estimates[0][0] * 1e-9
    ros.spin_until(lambda: bench.requests)
    arrival, tolerance = bench.requests[0]
    assert arrival >= first_estimate + 1.0
    assert arrival <= first_estimate + 1.0 + 0.2
    assert tolerance == pytest.approx(1e-3 / (2 * np.pi) * bench.estimates[0][1], rel=1e-12)


def test_without_delay_the_dead_zone_changes_at_once(ros, telemetry):
    bench = Bench(ros, communication_delay=0.0)
    bench.run(telemetry[:7500])
    ros.spin_until(lambda: bench.health["reconfigurations"] > 0)


def test_the_twin_tells_a_lockstep_plant_when_it_will_act(ros, telemetry):
    bench = Bench(ros, communication_delay=1.0)
    bench.run(telemetry[:7500])
    bench.wait_for_progress(1_499_800_000)
    earliest_action = nanoseconds_from_stamp(bench.progress[-1].time_ref)
    assert earliest_action == bench.twin._reconfigurator.next_due()
    assert bench.progress[-1].source == "twin"


def test_the_twin_promises_not_to_act_before_the_next_batch_and_the_delay(ros, telemetry):
    bench = Bench(ros, communication_delay=1.0)
    bench.run(telemetry[:BATCH])
    bench.wait_for_progress(99_800_000)
    assert nanoseconds_from_stamp(bench.progress[-1].time_ref) == 1_199_800_000


def test_without_delay_the_twin_promises_until_the_next_batch_is_published(ros, telemetry):
    bench = Bench(ros, communication_delay=0.0)
    bench.run(telemetry[:BATCH])
    bench.wait_for_progress(99_800_000)
    assert nanoseconds_from_stamp(bench.progress[-1].time_ref) == 200_000_000


def test_a_twin_that_only_estimates_promises_never_to_act(ros, telemetry):
    bench = Bench(ros, reconfigure=False)
    bench.run(telemetry[:BATCH])
    bench.wait_for_progress(99_800_000)
    assert bench.progress[-1].time_ref.sec == 2**31 - 1


def test_a_twin_that_only_estimates_leaves_the_controller_alone(ros, telemetry):
    bench = Bench(ros, reconfigure=False, communication_delay=0.0)
    bench.run(telemetry)
    ros.spin_until(lambda: bench.estimates)
    ros.spin_for(0.2)
    assert not bench.requests
    assert not any(DEAD_ZONE_JOINT in message.name for message in bench.messages)


def test_what_is_on_its_way_when_somebody_takes_the_dead_zone_over_does_not_arrive(ros, telemetry):
    bench = Bench(ros, communication_delay=1.0)
    bench.run(telemetry[:7500])
    ros.spin_until(lambda: bench.twin._reconfigurator.next_due() is not None)
    (result,) = bench.twin.set_parameters([Parameter("reconfigure", value=False)])
    assert result.successful
    bench.wait_for_progress(1_499_800_000)
    ros.spin_until(lambda: bench.progress[-1].time_ref.sec == 2**31 - 1)
    # A clock that goes on for more than 2 s at once is none.
    bench.tick(3.0)
    bench.tick(5.0)
    ros.spin_for(0.2)
    assert not bench.requests
    (result,) = bench.twin.set_parameters([Parameter("delay_spread", value=0.5)])
    assert not result.successful


def test_what_has_arrived_and_waits_for_the_controller_is_forgotten_with_the_take_over(
    ros, telemetry
):
    bench = Bench(ros, controller=False, communication_delay=0.0, service_timeout=60.0)
    bench.run(telemetry[:7500])
    ros.spin_until(lambda: bench.health["estimates"] > 0)
    (result,) = bench.twin.set_parameters([Parameter("reconfigure", value=False)])
    assert result.successful
    bench.start_controller()
    ros.spin_until(lambda: bench.progress and bench.progress[-1].time_ref.sec == 2**31 - 1)
    ros.spin_for(0.5)
    assert not bench.requests


def test_a_new_controller_is_left_alone_after_a_take_over(ros, telemetry):
    bench = Bench(ros, communication_delay=0.0)
    bench.run(telemetry[:7500])
    ros.spin_until(lambda: bench.health["reconfigurations"] >= 1)
    (result,) = bench.twin.set_parameters([Parameter("reconfigure", value=False)])
    assert result.successful
    ros.executor.remove_node(bench.peer)
    bench.peer.destroy_node()
    asked = len(bench.requests)
    bench.start_controller()
    ros.spin_for(0.5)
    assert len(bench.requests) == asked


def test_a_refusal_is_counted_and_the_twin_goes_on(ros, telemetry):
    bench = Bench(ros, accept=False, communication_delay=0.0)
    bench.run(telemetry)
    ros.spin_until(lambda: bench.health["failed_reconfigurations"] >= 2)
    assert bench.health["reconfigurations"] == 0


def test_a_controller_that_is_not_there_is_counted_and_the_twin_goes_on(ros, telemetry):
    bench = Bench(ros, controller=False, communication_delay=0.0, service_timeout=0.05)
    bench.run(telemetry)
    ros.spin_until(lambda: bench.health["failed_reconfigurations"] >= 1)
    assert bench.health["estimates"] > 0


def test_a_reconfiguration_without_an_answer_is_tried_again_until_it_has_one(ros, telemetry):
    """A twin that was paused, or a controller that was, must not cost a dead zone."""
    bench = Bench(ros, communication_delay=0.0, service_timeout=0.1)
    ros.executor.remove_node(bench.peer)
    bench.run(telemetry[:7500])
    ros.spin_until(lambda: bench.health["estimates"] > 0)
    sent = bench.health["estimates"]
    ros.spin_until(lambda: bench.health["failed_reconfigurations"] > sent + 2)
    assert bench.health["reconfigurations"] == 0
    assert bench.twin._delivery.next_due() is not None, "a plant in lockstep waits for it"
    bench.ros.executor.add_node(bench.peer)
    ros.spin_until(lambda: bench.health["reconfigurations"] == 1)
    in_force = bench.peer.get_parameter("dead_zone_tolerance").value
    assert in_force == pytest.approx(1e-3 / (2 * np.pi) * bench.estimates[-1][1], rel=1e-12)
    assert bench.twin._delivery.next_due() is None


def test_a_reconfiguration_without_an_answer_is_not_tried_again_after_a_take_over(ros, telemetry):
    bench = Bench(ros, communication_delay=0.0, service_timeout=0.3)
    ros.executor.remove_node(bench.peer)
    bench.run(telemetry[:7500])
    ros.spin_until(lambda: bench.twin._delivery.requests.in_flight is not None)
    (result,) = bench.twin.set_parameters([Parameter("reconfigure", value=False)])
    assert result.successful
    ros.spin_until(lambda: bench.twin._delivery.requests.in_flight is None)
    failed = bench.health["failed_reconfigurations"]
    ros.spin_for(0.5)
    assert bench.health["failed_reconfigurations"] == failed


def test_a_refused_reconfiguration_is_not_tried_again(ros, telemetry):
    bench = Bench(ros, accept=False, communication_delay=0.0)
    bench.run(telemetry[:7500])
    ros.spin_until(lambda: bench.health["failed_reconfigurations"] >= 1)
    ros.spin_until(lambda: bench.twin._delivery.next_due() is None)


def test_a_controller_that_comes_anew_is_sent_what_is_in_force_after_the_delay(ros, telemetry):
    bench = Bench(ros, communication_delay=0.2, service_timeout=1.0)
    bench.run(telemetry[:7500])
    ros.spin_until(lambda: bench.health["reconfigurations"] >= 1)
    # What was on its way is over before the new one comes.
    bench.tick(3.0)
    ros.spin_until(lambda: bench.twin._delivery.next_due() is None)
    in_force = bench.peer.get_parameter("dead_zone_tolerance").value
    ros.executor.remove_node(bench.peer)
    bench.peer.destroy_node()
    bench.peer = bench.start_controller()
    ros.spin_until(lambda: bench.twin._reconfigurator.next_due() is not None)
    assert bench.twin._reconfigurator.next_due() == 3_200_000_000
    asked = len(bench.requests)
    bench.tick(3.19)
    ros.spin_for(0.1)
    assert len(bench.requests) == asked
    bench.tick(3.2)
    ros.spin_until(lambda: len(bench.requests) > asked)
    assert bench.requests[-1][1] > 0.0
    assert bench.requests[-1][1] == pytest.approx(in_force, rel=0.1)


def test_the_first_controller_is_sent_nothing_but_what_is_estimated(ros):
    bench = Bench(ros, communication_delay=0.0)
    ros.spin_for(0.3)
    assert not bench.requests


@pytest.mark.parametrize("stamp", [-1, -(2**31) * 10**9])
def test_a_clock_before_zero_does_not_end_the_twin(ros, telemetry, stamp):
    bench = Bench(ros)
    bench.run(telemetry[:500])
    bench.clock.publish(Clock(clock=stamp_from_nanoseconds(stamp)))
    ros.spin_until(lambda: bench.health["rejected_messages_by_reason"] == "clock stamp: 1")
    assert bench.twin.get_clock().now().nanoseconds == 100_000_000


@pytest.mark.parametrize("factor", [1e3, 3e9, 1e300])
def test_telemetry_of_absurd_times_is_rejected_and_the_run_goes_on(ros, telemetry, factor):
    bench = Bench(ros)
    bench.run(telemetry[:1000])
    rows = telemetry[1000:1500].copy()
    rows[:, 0] *= factor
    bench.send(rows)
    assert bench.health["rejected_messages"] == 1
    bench.run(telemetry[1000:7500])
    assert bench.health["rejected_messages"] == 1
    assert bench.health["estimates"] > 0


@pytest.mark.parametrize("start", [0.0, 1_795_000_000.0])
def test_simulated_time_without_a_clock_is_told(ros, telemetry, start):
    """Left true with hardware: estimates, and no reconfiguration ever arrives."""
    bench = Bench(ros, communication_delay=0.0)
    rows = telemetry.copy()
    rows[:, 0] += start
    for first in range(0, 7500, BATCH):
        bench.send(rows[first : first + BATCH])
    ros.spin_until(lambda: bench.health["estimates"] > 0)
    health = bench.twin._health()
    assert not health.ok
    assert "use_sim_time is true and nobody publishes /clock" in health.summary
    assert not bench.requests


def test_two_twins_are_noticed(ros):
    bench = Bench(ros)
    ros.create(TwinNode)
    ros.spin_until(
        lambda: bench.health["topics_with_several_publishers"] == "backlash_estimate: /twin, /twin"
    )


def broken(rows, how):
    rows = rows.copy()
    if how == "nan":
        rows[3, 2] = np.nan
    if how == "hole":
        rows[250:, 0] += 0.01
    return rows


@pytest.mark.parametrize("rate", [1000.0, 4000.0])
def test_telemetry_of_another_rate_is_rejected_and_the_step_is_told(ros, telemetry, rate):
    """What docs/source/how-to/use-your-own-hardware.md promises."""
    bench = Bench(ros, estimator__sampling_rate=rate)
    bench.tick(0.1)
    for start in (0, BATCH):
        bench.send(telemetry[start : start + BATCH])
    ros.spin_until(lambda: bench.health["rejected_messages_by_reason"] == "telemetry samples: 2")
    last = bench.health["last_rejected_message"]
    assert last.startswith("telemetry: time step of 0.0002")
    assert bench.health["estimates"] == 0


def test_telemetry_with_jitter_is_taken_and_the_diagnostics_say_how(ros, telemetry):
    bench = Bench(ros, estimator__kind="output_error")
    assert bench.health["telemetry_sampling"] == "even"
    rows, generator = telemetry.copy(), np.random.default_rng(0)
    rows[1:, 0] += np.clip(generator.normal(0.0, 3e-5, len(rows) - 1), -9e-5, 9e-5)
    bench.tick(0.1)
    for start in range(0, len(rows), BATCH):
        bench.send(rows[start : start + BATCH])
    assert bench.health["rejected_messages"] == 0
    assert bench.health["telemetry_sampling"].startswith("interpolated: 5000")
    ros.spin_until(lambda: bench.estimates)


def test_batches_of_any_length_give_the_same_estimates(ros, telemetry):
    bench = Bench(ros)
    ends = [0, 1, 8, 500, 1733, 1734, 7500]
    for first, end in pairwise(ends):
        bench.send(telemetry[first:end])
    core = InverseFilterEstimator(PlantModel(), InverseFilterSettings())
    expected = [one.gap for one in core.estimates(telemetry[:7500, 1], telemetry[:7500, 2])]
    ros.spin_until(lambda: bench.estimates and bench.estimates[-1][1] == expected[-1])


def test_a_clock_that_goes_back_makes_the_next_but_one_batch_another_run(ros, telemetry):
    bench = Bench(ros)
    rows = telemetry.copy()
    rows[:, 0] += 5.0
    bench.tick(5.0)
    bench.send(rows[:500])
    bench.send(rows[500:1000])
    bench.send(telemetry[:500])
    assert bench.health["rejected_messages_by_reason"] == "telemetry time: 1"
    ros.spin_for(2 * SILENCE)
    bench.send(telemetry[500:1000])
    bench.wait_for_progress(199_800_000)
    assert bench.health["telemetry_accepted"] == 4


STUBBORN = """
from bdt_twin.estimator import Estimate

class Stubborn:
    def __init__(self, model, sampling_rate):
        pass

    def restart(self):
        pass

    def update(self, batch, *, newest_only=False):
        return Estimate(
            float(batch[-1, 0]) - 0.05,
            0.25,
            uncertainty=0.01,
            growth=0.002,
            reversals=3,
            age=0.05,
        )
"""


def test_an_estimator_of_somebody_else_sets_a_dead_zone_with_its_margin(
    ros, telemetry, tmp_path, monkeypatch
):
    (tmp_path / "stubborn.py").write_text(STUBBORN)
    monkeypatch.syspath_prepend(tmp_path)
    bench = Bench(
        ros,
        estimator__kind="stubborn:Stubborn",
        dead_zone__coverage_factor=2.0,
        communication_delay=0.1,
    )
    bench.run(telemetry[:1500])
    ros.spin_until(lambda: bench.requests)
    expected = 1e-3 / (2 * np.pi) * (0.25 + 2.0 * 0.01 + (0.05 + 0.1) * 0.002)
    assert bench.requests[0][1] == pytest.approx(expected, rel=1e-9)
    ros.spin_until(lambda: bench.messages)
    stamp = round(telemetry[BATCH - 1, 0] * 1e9) - 50_000_000
    assert read_position(bench.messages[0], GAP_AGE_JOINT) == (stamp, 0.05)
    assert read_position(bench.messages[0], DEAD_ZONE_JOINT) == (stamp, bench.requests[0][1])
    assert bench.health["gap_uncertainty_rad"] == 0.01
    assert bench.health["reversals"] == 3
    assert bench.health["estimator"] == "stubborn:Stubborn"


OFFSET = """
from bdt_twin.estimator import Estimate

class Offset:
    def restart(self):
        pass

    def update(self, batch):
        return Estimate(
            batch[-1, 0], 0.25, voltage_offset=0.02, voltage_offset_uncertainty=0.001
        )
"""


@pytest.fixture
def offset_estimator(tmp_path, monkeypatch):
    (tmp_path / "offset.py").write_text(OFFSET)
    monkeypatch.chdir(tmp_path)
    yield "offset:Offset"
    sys.modules.pop("offset")


def test_the_amplifier_s_offset_is_compensated_with_the_dead_zone(ros, telemetry, offset_estimator):
    bench = Bench(ros, estimator__kind=offset_estimator, communication_delay=0.0)
    bench.peer.declare_parameter("voltage_offset", 0.0)
    bench.run(telemetry[:BATCH])
    ros.spin_until(lambda: bench.health["reconfigurations"] == 1)
    assert bench.peer.get_parameter("dead_zone_tolerance").value > 0.0
    assert bench.peer.get_parameter("voltage_offset").value == -0.02
    assert bench.health["voltage_offset_estimate_v"] == 0.02
    assert bench.health["voltage_offset_uncertainty_v"] == 0.001
    ros.spin_until(lambda: bench.messages)
    assert read_voltage(bench.messages[0], VOLTAGE_OFFSET_JOINT)[1] == -0.02


def test_a_controller_without_a_voltage_offset_gets_its_dead_zone(ros, telemetry, offset_estimator):
    bench = Bench(ros, estimator__kind=offset_estimator, communication_delay=0.0)
    bench.run(telemetry[:BATCH])
    ros.spin_until(lambda: bench.health["reconfigurations"] == 1)
    assert bench.peer.get_parameter("dead_zone_tolerance").value > 0.0
    assert bench.health["refused_voltage_offsets"] == 1
    assert bench.health["failed_reconfigurations"] == 0


def test_an_offset_that_somebody_has_taken_over_is_left_alone(ros, telemetry, offset_estimator):
    """Also what is on its way when they do."""
    bench = Bench(ros, estimator__kind=offset_estimator, communication_delay=0.2)
    bench.peer.declare_parameter("voltage_offset", 0.0)
    bench.run(telemetry[:BATCH])
    ros.spin_until(lambda: bench.twin._reconfigurator.next_due() is not None)
    (result,) = bench.twin.set_parameters([Parameter("compensate_offset", value=False)])
    assert result.successful
    bench.tick(0.4)
    ros.spin_until(lambda: bench.health["reconfigurations"] == 1)
    assert bench.peer.get_parameter("dead_zone_tolerance").value > 0.0
    assert bench.peer.get_parameter("voltage_offset").value == 0.0
    bench.run(telemetry[BATCH : 2 * BATCH])
    ros.spin_until(lambda: len(bench.messages) == 2)
    assert VOLTAGE_OFFSET_JOINT not in bench.messages[1].name


def test_a_controller_that_comes_anew_is_sent_the_voltage_offset_as_well(
    ros, telemetry, offset_estimator
):
    bench = Bench(ros, estimator__kind=offset_estimator, communication_delay=0.0)
    bench.peer.declare_parameter("voltage_offset", 0.0)
    bench.run(telemetry[:BATCH])
    ros.spin_until(lambda: bench.health["reconfigurations"] == 1)
    ros.executor.remove_node(bench.peer)
    bench.peer.destroy_node()
    bench.peer = bench.start_controller()
    bench.peer.declare_parameter("voltage_offset", 0.0)
    ros.spin_until(lambda: bench.peer.get_parameter("voltage_offset").value == -0.02)
    assert bench.peer.get_parameter("dead_zone_tolerance").value > 0.0


UNSURE = """
import math

from bdt_twin.estimator import Estimate

class Unsure:
    def restart(self):
        self.uncertainty = 10.0

    def update(self, batch):
        self.uncertainty /= 1000.0
        return Estimate(batch[-1, 0], 0.25, 1000.0 * self.uncertainty)
"""


def test_a_dead_zone_at_its_bound_is_a_warning(ros, telemetry, tmp_path, monkeypatch):
    (tmp_path / "unsure.py").write_text(UNSURE)
    monkeypatch.chdir(tmp_path)
    bench = Bench(
        ros,
        estimator__kind="unsure:Unsure",
        dead_zone__coverage_factor=2.0,
        dead_zone__largest_growth=0.3,
        communication_delay=0.0,
    )
    bench.run(telemetry[:BATCH])
    ros.spin_until(lambda: bench.requests)
    assert bench.requests[0][1] == pytest.approx(1e-3 / (2 * np.pi) * (0.25 + 0.3), rel=1e-9)
    for _ in range(2):
        health = bench.twin._health()
        assert not health.ok, "as long as it lasts"
        assert "the gap is too uncertain: dead_zone.largest_growth bounds" in health.summary
        assert health.values["dead_zone_at_bound"]
    bench.run(telemetry[BATCH : 2 * BATCH])
    ros.spin_until(lambda: bench.health["estimates"] == 2)
    health = bench.twin._health()
    assert health.ok
    assert not health.values["dead_zone_at_bound"]
    sys.modules.pop("unsure")


NOW_AND_THEN = """
import time

from bdt_twin.estimator import Estimate

class NowAndThen:
    def restart(self):
        self.batches = 0

    def update(self, batch):
        self.batches += 1
        if self.batches > 1:
            return None
        time.sleep(0.2)
        return Estimate(batch[-1, 0], 0.25)
"""


def test_the_time_of_a_window_is_that_of_the_last_estimate(ros, telemetry, tmp_path, monkeypatch):
    """Most batches only wait for the window to be full."""
    (tmp_path / "now_and_then.py").write_text(NOW_AND_THEN)
    monkeypatch.chdir(tmp_path)
    bench = Bench(ros, estimator__kind="now_and_then:NowAndThen")
    bench.run(telemetry[: 3 * BATCH])
    ros.spin_until(lambda: bench.health["telemetry_accepted"] == 3)
    assert bench.health["window_time_s"] >= 0.2
    sys.modules.pop("now_and_then")


FAILS_ONCE = """
from bdt_twin.estimator import Estimate

class FailsOnce:
    def restart(self):
        self.batches = 0

    def update(self, batch):
        self.batches += 1
        if self.batches == 2:
            raise RuntimeError("no idea")
        return Estimate(batch[-1, 0], 0.25)
"""


def test_an_error_of_somebody_s_estimator_is_told_and_the_twin_goes_on(
    ros, telemetry, tmp_path, monkeypatch
):
    (tmp_path / "fails_once.py").write_text(FAILS_ONCE)
    monkeypatch.chdir(tmp_path)
    bench = Bench(ros, estimator__kind="fails_once:FailsOnce", communication_delay=0.0)
    bench.run(telemetry[:BATCH])
    ros.spin_until(lambda: bench.requests)
    assert bench.health["estimator_errors"] == 0
    bench.run(telemetry[BATCH : 2 * BATCH])
    assert bench.health["estimator_errors"] == 1
    assert bench.health["estimator_error"] == "fails_once.py:11: RuntimeError: no idea"
    assert bench.health["gap_estimate_rad"] == 0.25, "the last estimate is kept"
    bench.run(telemetry[2 * BATCH : 3 * BATCH])
    assert bench.health["estimates"] == 2
    assert bench.health["estimator_errors"] == 1
    sys.modules.pop("fails_once")


@pytest.mark.parametrize("how", ["nan", "hole", "back in time", "lost batch"])
def test_telemetry_that_does_not_continue_is_rejected_and_counted(ros, telemetry, how):
    bench = Bench(ros)
    bench.run(telemetry[:1000])
    if how == "back in time":
        bench.send(telemetry[:500])
        ros.spin_for(2 * SILENCE)
        following = telemetry[500:1000]
    elif how == "lost batch":
        bench.telemetry.publish(sample_message(telemetry[1500:2000], TELEMETRY_COLUMNS))
        ros.spin_for(2 * SILENCE)
        bench.send(telemetry[2000:2500])
        following = telemetry[2500:3000]
    else:
        bench.send(broken(telemetry[1000:1500], how))
        following = telemetry[1500:2000]
    assert bench.health["rejected_messages"] == 1
    bench.send(following)
    assert bench.health["rejected_messages"] == 1


def test_messages_without_the_layout_of_telemetry_are_rejected_and_counted(ros):
    bench = Bench(ros)
    bench.telemetry.publish(Float64MultiArray())
    ros.spin_until(lambda: bench.health["rejected_messages"] == 1)


@pytest.mark.parametrize(
    ("parameters", "says"),
    [
        ({"communication_delay": -1.0}, "communication_delay = -1.0"),
        ({"estimator__window": 0.25}, "window = 0.25 s: must be a multiple of update_period"),
        ({"estimator__delay": 0}, "estimator.delay = 0: must be an integer, 1 to 1000 samples"),
        ({"reconfigure": 1}, "reconfigure = 1: must be true or false"),
        ({"estimator__kind": "kalman"}, "kind = 'kalman': must be one of inverse_filter"),
        ({"estimator__kind": "nowhere:Found"}, "estimator.kind = 'nowhere:Found': No module"),
        ({"estimator__windw": 2.0}, "is not a parameter of /twin"),
    ],
)
def test_a_start_with_bad_parameters_names_parameter_value_and_what_is_allowed(
    ros, parameters, says
):
    watcher = ros.create(Node, "watcher")
    with pytest.raises(ConfigurationError) as caught:
        ros.create(TwinNode, **parameters)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)
    ros.spin_until(lambda: watcher.get_node_names() == ["watcher"])


def test_a_twin_that_simulates_commands_what_its_core_decides_and_tells_why(ros, telemetry):
    bench = Bench(ros, communication_delay=0.5, decision__kind="simulate", decision__members=2)
    bench.run(telemetry)
    settings = DecisionSettings(kind="simulate", members=2)
    gains = ControllerGains(PidGains(), NotchFilter())
    estimator = InverseFilterEstimator(PlantModel(), InverseFilterSettings())
    decide = create_decider(settings, PlantModel(), gains, gains, estimator, 0.5, 0.0)
    batches = [telemetry[start : start + BATCH] for start in range(0, len(telemetry), BATCH)]
    decisions = [
        decide(rows, estimator.update(rows), begins=number == 0)
        for number, rows in enumerate(batches)
    ]
    expected = [one.tolerance for one in decisions if one is not None and one.tolerance]
    ros.spin_until(lambda: bench.requests)
    assert bench.requests[0][1] in expected
    assert bench.health["decision"] == "simulate"
    assert bench.health["decision_reason"] == decisions[-1].reason
    assert bench.health["expected_bias_percent"] == 100.0 * decisions[-1].bias


def test_a_decision_that_was_taken_back_is_a_warning_as_long_as_simulation_is_not_trusted(ros):
    bench = Bench(ros, decision__kind="simulate")
    assert bench.twin._health().ok
    decision = Decision(None, None, "eq. 9, as the loop has not rested", distrust="not rested")
    bench.twin._record.use(Estimate(1.0, 0.1), decision)
    health = bench.twin._health()
    assert (health.ok, health.summary) == (False, "eq. 9, as the loop has not rested")


@pytest.mark.parametrize("name", ["pid.proportional", "notch.frequency", "redesign.integral"])
def test_what_the_twin_knows_of_the_controller_is_read_once(ros, name):
    bench = Bench(ros)
    (result,) = bench.twin.set_parameters([Parameter(name, value=1.0)])
    assert not result.successful
    assert bench.twin.describe_parameter(name).read_only


@pytest.mark.parametrize(
    ("name", "allowed"),
    [
        ("reconfigure", "true or false"),
        ("communication_delay", "0 to 10000 s"),
        ("estimator.kind", "a text"),
    ],
)
def test_a_description_says_what_is_allowed(ros, name, allowed):
    assert Bench(ros).twin.describe_parameter(name).additional_constraints == allowed


def test_a_switch_that_is_given_a_number_says_what_it_takes_and_no_more(ros):
    with pytest.raises(ConfigurationError, match=r"must be true or false$"):
        ros.create(TwinNode, reconfigure=1)
