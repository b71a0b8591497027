"""Callback groups forget what is gone: a node may make and destroy timers as long as it runs."""

import gc

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node


def test_a_group_holds_nothing_of_what_was_destroyed(ros):
    node = Node("maker", context=ros.context)
    group = MutuallyExclusiveCallbackGroup()
    kept = node.create_timer(10.0, print, group)
    for _ in range(50):
        node.destroy_timer(node.create_timer(10.0, print, group))
        node.destroy_guard_condition(node.create_guard_condition(print, group))
    gc.collect()
    assert [reference() for reference in group.entities] == [kept]
    assert group.has_entity(kept)
    node.destroy_node()
