"""Ends of the transport benchmarks: whoever misses the first messages is asked again."""

import json
import os
from importlib.util import find_spec

import pytest
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from bdt_study.benchmarks import processes, transport
from bdt_study.benchmarks.transport_node import DEPTH, KEEP_ALL

COUNT = 20


@pytest.fixture
def node(ros, monkeypatch):
    """Return the other end: a node in this process."""
    monkeypatch.setattr(processes, "domain", lambda: int(os.environ["ROS_DOMAIN_ID"]))
    from rclpy.node import Node

    return ros.create(lambda **options: Node("other_end", **options))


def spin_until_done(ros, process):
    ros.spin_until(lambda: process.poll() is not None, deadline=60.0)
    out, err = process.communicate()
    assert process.returncode == 0, err
    return json.loads(out)


@pytest.mark.parametrize("lost", [0, 1, 3])
def test_a_ping_whose_answer_is_lost_is_sent_again(ros, node, lost):
    """A publisher that was counted may not be matched yet: its first messages go nowhere."""
    heard = []
    publisher = node.create_publisher(JointState, "pong", DEPTH)

    def echo(message):
        heard.append(message.header.stamp.sec)
        if len(heard) > lost:
            publisher.publish(message)

    node.create_subscription(JointState, "ping", echo, DEPTH)
    with processes.peer(transport.TRANSPORT_NODE, ["ping", str(COUNT)], wait=False) as ping:
        assert spin_until_done(ros, ping)["seconds"] > 0
    assert heard[: lost + 1] == [0] * (lost + 1)
    assert sorted(set(heard)) == list(range(COUNT // 10 + COUNT))


@pytest.mark.parametrize("lost", [0, 3])
@pytest.mark.parametrize(("kind", "numbers"), [(JointState, 0), (Float64MultiArray, 5)])
def test_messages_are_counted_once_the_reader_hears_them(ros, node, kind, numbers, lost):
    empty, full = [], []
    heard = node.create_publisher(JointState, "heard", DEPTH)

    def take(message):
        if len(message.data if numbers else message.name):
            full.append(message)
            return
        empty.append(message)
        if len(empty) > lost:
            heard.publish(JointState())

    subscription = node.create_subscription(kind, "stream", take, KEEP_ALL)
    words = ["send", str(COUNT), str(numbers)]
    with processes.peer(transport.TRANSPORT_NODE, words, wait=False) as sender:
        ros.spin_until(lambda: len(full) == COUNT)
        assert len(empty) > lost
        node.destroy_subscription(subscription)
        assert spin_until_done(ros, sender)["cpu"] > 0


@pytest.mark.skipif(find_spec("cyclonedds") is None, reason="needs the Python package cyclonedds")
@pytest.mark.parametrize("lost", [0, 1, 3])
def test_bytes_whose_answer_is_lost_are_sent_again(lost, capsys):
    from bdt_study.benchmarks import dds_participant

    written, answers = [], []

    class ForgetfulEcho:
        def matched(self):
            return True

        def write(self, payload):
            written.append(payload)
            if len(written) > lost:
                answers.append(payload)

        def take(self):
            return answers.pop(0) if answers else b""

    dds_participant.ping(ForgetfulEcho(), COUNT)
    assert json.loads(capsys.readouterr().out)["seconds"] > 0
    assert len(set(written)) == COUNT // 10 + COUNT
    assert len(written) == len(set(written)) + lost
    assert set(map(len, written)) == {len(written[0])}
