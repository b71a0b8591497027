"""Waiting for one message."""

import threading

import pytest
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.wait_for_message import wait_for_message
from std_msgs.msg import Float64, String


def test_one_message_can_be_waited_for(ros):
    sender, waiter = Node("sender", context=ros.context), Node("waiter", context=ros.context)
    profile = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    sender.create_publisher(String, "s", profile).publish(String(data="x"))
    found = wait_for_message(String, waiter, "s", qos_profile=profile, time_to_wait=20)
    assert found == (True, String(data="x"))
    assert wait_for_message(String, waiter, "none", time_to_wait=0.01) == (False, None)
    sender.destroy_node()
    waiter.destroy_node()


def test_a_message_that_comes_later_is_waited_for(ros):
    waiter = Node("waiter", context=ros.context)
    publisher = waiter.create_publisher(Float64, "x", 1)

    def publish():
        ros.wait_until(publisher.get_subscription_count)
        publisher.publish(Float64(data=3.0))

    sender = threading.Thread(target=publish)
    sender.start()
    assert wait_for_message(Float64, waiter, "x", time_to_wait=20) == (True, Float64(data=3.0))
    sender.join(20)
    assert publisher.get_subscription_count() == 0
    waiter.destroy_node()


def test_options_are_named(ros, node):
    with pytest.raises(TypeError):
        wait_for_message(Float64, node, "x", 1, 0.01)
