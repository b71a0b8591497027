"""Two nodes of a kind in one domain: the second one is noticed, and changes nothing."""

import numpy as np
import pytest
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from bdt_controller.controller_node import ControllerNode
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import read_samples
from bdt_msgs_py.topics import REFERENCE, TELEMETRY, TELEMETRY_COLUMNS
from bdt_plant.plant_node import PlantNode
from bdt_twin.twin_node import TwinNode

DURATION = 4.0


class Loop:
    """A loop in lockstep that can be stopped at a simulated time."""

    def __init__(self, ros):
        self.ros, self.telemetry = ros, []
        listener = ros.create(Node, "listener")
        listener.create_subscription(
            Float64MultiArray,
            TELEMETRY.name,
            lambda message: self.telemetry.append(read_samples(message, TELEMETRY_COLUMNS).copy()),
            qos_profile(TELEMETRY),
        )
        self.controller = ros.create(ControllerNode, use_sim_time=True, reference__step_time=1.0)
        self.twin = ros.create(TwinNode, use_sim_time=True, communication_delay=0.3)
        self.plant = ros.create(PlantNode, duration=DURATION, lockstep_followers=["twin"])

    def run_until(self, time):
        self.ros.spin_until(lambda: self.plant._simulator.time >= time, 60.0)

    def finish(self):
        self.ros.result(self.plant.finished, 60.0)
        self.ros.spin_until(lambda: self.telemetry[-1][-1, 0] > DURATION - 0.01)
        return np.concatenate(self.telemetry)


@pytest.fixture(scope="module")
def alone(ros_loops):
    """Telemetry of a loop without anybody else."""
    loop = Loop(ros_loops())
    telemetry = loop.finish()
    loop.ros.close()
    return telemetry


def says(node, name, nodes):
    health = node._health()
    return not health.ok and f"{name}: {nodes}" in health.values["topics_with_several_publishers"]


def test_a_second_controller_stands_by_and_disturbs_nothing(alone, ros):
    loop = Loop(ros)
    loop.run_until(1.0)
    references = []
    # A reference that the second one would have set from its first measurement on.
    second = ros.create(
        ControllerNode, use_sim_time=True, pid__proportional=-1e5, reference__first=1e-3
    )
    listener = ros.create(Node, "reference_listener")
    listener.create_subscription(
        JointState,
        REFERENCE.name,
        lambda message: references.append(message.position[0]),
        qos_profile(REFERENCE),
    )
    assert np.array_equal(loop.finish(), alone)
    assert loop.plant._health().values["rejected_messages"] == 0
    assert set(references) == {0.0, 5e-3}
    for node in (loop.plant, loop.controller, second):
        assert says(node, "command", "/controller, /controller")
    assert "another controller answers: standing by" in second._health().summary


def test_a_controller_that_stands_by_takes_over_and_goes_on_with_the_reference(ros):
    loop = Loop(ros)
    loop.run_until(1.0)
    second = ros.create(ControllerNode, use_sim_time=True, reference__step_time=1.0)
    ros.spin_until(lambda: "standing by" in second._health().summary, 60.0)
    ros.executor.remove_node(loop.controller)
    loop.controller.destroy_node()
    rows = loop.finish()
    assert second._health().values["reference_began_s"] == 0.0
    assert abs(rows[-1, 2]) < 1e-3, "the fourth step is one to 0"


def test_measurements_of_a_second_plant_are_not_obeyed(alone, ros):
    loop = Loop(ros)
    loop.run_until(1.0)
    # With the same clock it would not start.
    words = ["--ros-args", "-r", "/clock:=/other_clock"]
    # More often than this its timer may leave a slow executor no time for the first one.
    second = ros.create(lambda **options: PlantNode(cli_args=words, **options), resend_period=0.05)
    ros.spin_until(lambda: says(second, "measurement", "/plant, /plant"))
    assert np.array_equal(loop.finish(), alone)
    assert says(loop.plant, "measurement", "/plant, /plant")
    reasons = loop.controller._health().values["rejected_messages_by_reason"]
    assert "measurement time: " in reasons


def test_a_second_twin_is_noticed(ros):
    loop = Loop(ros)
    loop.run_until(1.0)
    second = ros.create(TwinNode, use_sim_time=True)
    for node in (loop.twin, second):
        ros.spin_until(lambda node=node: says(node, "backlash_estimate", "/twin, /twin"))


def test_a_controller_that_is_killed_and_started_anew_takes_the_loop_over(ros):
    loop = Loop(ros)
    loop.run_until(2.0)
    ros.spin_until(lambda: loop.controller.get_parameter("dead_zone_tolerance").value > 0.0, 60.0)
    ros.executor.remove_node(loop.controller)
    loop.controller.destroy_node()
    anew = ros.create(ControllerNode, use_sim_time=True, reference__step_time=1.0)
    ros.spin_until(lambda: anew.get_parameter("dead_zone_tolerance").value > 0.0)
    loop.finish()


def test_a_plant_that_is_started_anew_begins_another_run(ros):
    loop = Loop(ros)
    first = loop.finish()
    ros.executor.remove_node(loop.plant)
    loop.plant.destroy_node()
    loop.telemetry.clear()
    loop.plant = ros.create(PlantNode, duration=DURATION, lockstep_followers=["twin"])
    second = loop.finish()
    assert len(second) == len(first)
    # The dead zone of the run before is in force until the first estimate; the reference is not.
    assert second[0, 0] == 0.0
    assert loop.controller._health().values["restarts"] == 1
