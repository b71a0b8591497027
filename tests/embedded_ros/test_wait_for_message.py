"""Waiting for a message, where embedded_ros does better than rclpy."""

import threading

from rclpy.node import Node
from rclpy.wait_for_message import wait_for_message
from std_msgs.msg import String


def test_waiting_for_a_message_ends_with_the_context(ros):
    # rclpy 7.1 goes on waiting here, unless the context was shut down by a signal.
    waiter = Node("waiter", context=ros.context)
    threading.Timer(0.05, ros.context.try_shutdown).start()
    assert wait_for_message(String, waiter, "none") == (False, None)
    waiter.destroy_node()
