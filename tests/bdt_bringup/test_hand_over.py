"""Messages between nodes of a process: who gets them when, and in which order."""

import pytest
from rclpy.node import Node
from sensor_msgs.msg import JointState

from bdt_bringup.hand_over import HandingPublisher, HandOver, handing_node
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import COMMAND, MEASUREMENT, TELEMETRY


class Wire:
    """Stands for a publisher: notes what goes to a topic."""

    def __init__(self, done, topic):
        self.done, self.topic = done, topic
        self.topic_name = f"/{topic.name}"

    def publish(self, message):
        self.done.append(f"{self.topic.name} {message}")


class Stage:
    """Two nodes: one measures, and one commands in its callback."""

    def __init__(self):
        self.done = []
        self.hand_over = HandOver()
        self.measurement, self.command, self.telemetry = (
            HandingPublisher(self.hand_over, topic, Wire(self.done, topic))
            for topic in (MEASUREMENT, COMMAND, TELEMETRY)
        )
        self.hand_over.take(MEASUREMENT, self.answer)
        self.hand_over.take(COMMAND, self.obey)

    def answer(self, message):
        self.done.append("answer")
        self.command.publish(message)

    def obey(self, message):
        self.done.append("obey")
        if message == "bad":
            raise ValueError(message)


def test_an_answer_is_obeyed_before_anything_is_published_and_the_order_stays():
    stage = Stage()
    stage.measurement.publish(1)
    stage.measurement.publish(2)
    one = ["answer", "obey", "measurement 1", "command 1"]
    assert stage.done == [*one, *(line.replace("1", "2") for line in one)]


def test_what_nobody_takes_here_is_published():
    stage = Stage()
    stage.telemetry.publish(1)
    assert stage.done == ["telemetry 1"]


def test_what_a_callback_raises_costs_no_message():
    stage = Stage()
    with pytest.raises(ValueError, match="bad"):
        stage.measurement.publish("bad")
    assert stage.done[2:] == ["measurement bad", "command bad"]
    stage.done.clear()
    stage.measurement.publish(1)
    assert stage.done == ["answer", "obey", "measurement 1", "command 1"]


def test_it_has_what_a_publisher_has():
    assert Stage().command.topic_name == "/command"


@pytest.mark.parametrize("hears_others", [False, True])
def test_a_node_takes_from_the_other_one_and_if_wanted_from_everybody(ros, hears_others):
    hand_over, taken = HandOver(), []
    giver = ros.create(
        handing_node(Node, hand_over, gives=COMMAND, takes=MEASUREMENT, hears_others=False), "giver"
    )
    taker = ros.create(
        handing_node(Node, hand_over, gives=MEASUREMENT, takes=COMMAND, hears_others=hears_others),
        "taker",
    )
    stranger = ros.create(Node, "stranger")
    profile = qos_profile(COMMAND)
    taker.create_subscription(
        JointState, COMMAND.name, lambda message: taken.append(message.name[0]), profile
    )
    ros.spin_until(lambda: taker.count_subscribers("/command") == hears_others)
    giver.create_publisher(JointState, COMMAND.name, profile).publish(JointState(name=["giver"]))
    assert taken == ["giver"]
    if hears_others:
        publisher = stranger.create_publisher(JointState, COMMAND.name, profile)
        ros.spin_until(lambda: publisher.get_subscription_count() == 1)
        publisher.publish(JointState(name=["stranger"]))
        ros.spin_until(lambda: "stranger" in taken)
