"""One plant owns simulated time: what it does about another publisher of its clock."""

import pytest
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import CLOCK, MEASUREMENT
from bdt_plant import clock_owner
from bdt_plant.plant_node import PlantNode

MODES = ("lockstep", "realtime")


def publisher_of_the_clock(ros, name):
    node = ros.create(Node, name)
    node.create_publisher(Clock, CLOCK.name, qos_profile(CLOCK))
    return node


def other_clock(ros):
    """Let a node publish the clock, and wait until it is seen."""
    publisher_of_the_clock(ros, "other")
    watcher = ros.create(Node, "watcher")
    ros.spin_until(lambda: watcher.count_publishers(CLOCK.name) == 1)


def heard(ros, kind, topic):
    messages = []
    listener = ros.create(Node, "listener")
    listener.create_subscription(kind, topic.name, messages.append, qos_profile(topic))
    return messages


@pytest.mark.parametrize("mode", MODES)
def test_a_plant_refuses_a_clock_that_another_node_publishes_and_says_nothing_on_it(ros, mode):
    other_clock(ros)
    clock, measurements = heard(ros, Clock, CLOCK), heard(ros, JointState, MEASUREMENT)
    plant = ros.create(PlantNode, mode=mode)
    with pytest.raises(BadInputError) as caught:
        ros.result(plant.finished)
    assert str(caught.value) == (
        "/plant: /clock is published by /other, too: stop one of them, or let every node of this "
        "loop have a clock of its own with -r /clock:=clock in a namespace"
    )
    ros.spin_for(0.3)
    assert not clock
    assert not measurements


@pytest.mark.parametrize("mode", MODES)
def test_a_plant_that_runs_gives_a_newcomer_time_to_go(ros, mode, monkeypatch):
    monkeypatch.setattr(clock_owner, "PATIENCE", 0.7)
    measurements = heard(ros, JointState, MEASUREMENT)
    plant = ros.create(PlantNode, mode=mode, resend_period=0.1)
    ros.spin_until(lambda: measurements)
    newcomer = publisher_of_the_clock(ros, "second")
    ros.spin_for(0.3)
    ros.executor.remove_node(newcomer)
    newcomer.destroy_node()
    ros.nodes.remove(newcomer)
    ros.spin_for(1.0)
    assert not plant.finished.done()
    publisher_of_the_clock(ros, "second")
    with pytest.raises(BadInputError, match="/clock is published by /second, too"):
        ros.result(plant.finished)


def test_a_clock_of_its_own_in_a_namespace_disturbs_nobody(ros):
    other_clock(ros)
    words = ["--ros-args", "-r", "__ns:=/left", "-r", "/clock:=clock"]
    plant = ros.create(lambda **options: PlantNode(cli_args=words, **options))
    clock = []
    listener = ros.create(Node, "listener")
    listener.create_subscription(Clock, "/left/clock", clock.append, qos_profile(CLOCK))
    ros.spin_until(lambda: clock)
    assert not plant.finished.done()
