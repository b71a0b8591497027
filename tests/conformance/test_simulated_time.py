"""Simulated time from ``/clock``."""

import pytest
from rclpy.clock import Clock, ClockChange, ClockType, JumpThreshold
from rclpy.duration import Duration
from rclpy.parameter import Parameter
from rclpy.time import Time
from rosgraph_msgs.msg import Clock as ClockMsg

SECOND = 10**9


@pytest.fixture
def simulated(ros):
    node = ros.node("simulated", parameter_overrides=[Parameter("use_sim_time", value=True)])
    source = ros.node("source")
    publisher = source.create_publisher(ClockMsg, "/clock", 10)

    def set_time(seconds):
        stamp = Time(seconds=seconds, clock_type=ClockType.ROS_TIME)
        publisher.publish(ClockMsg(clock=stamp.to_msg()))
        ros.spin_until(lambda: node.get_clock().now() == stamp)
        ros.executor.spin_once(timeout_sec=0)

    assert publisher.get_subscription_count() == 1
    return node, set_time


def test_simulated_time_starts_at_zero_and_follows_the_topic(simulated):
    node, set_time = simulated
    assert node.get_clock().ros_time_is_active
    assert node.get_clock().now().nanoseconds == 0
    set_time(12.5)
    assert node.get_clock().now().nanoseconds == 12_500_000_000


def test_a_timer_fires_when_simulated_time_reaches_it(ros, simulated):
    node, set_time = simulated
    set_time(100.0)
    calls = []
    node.create_timer(1.0, lambda: calls.append(node.get_clock().now().nanoseconds / SECOND))
    set_time(100.9)
    ros.spin_for(0.02)
    assert calls == []
    set_time(101.0)
    ros.spin_until(lambda: calls == [101.0])
    # A far jump is one call; the next one is at a multiple of the period.
    set_time(110.5)
    ros.spin_until(lambda: calls == [101.0, 110.5])
    set_time(110.9)
    set_time(111.0)
    ros.spin_until(lambda: calls == [101.0, 110.5, 111.0])


def test_a_jump_back_restarts_the_period(ros, simulated):
    node, set_time = simulated
    set_time(100.0)
    calls = []
    node.create_timer(1.0, lambda: calls.append(node.get_clock().now().nanoseconds / SECOND))
    set_time(50.0)
    set_time(50.9)
    assert calls == []
    set_time(51.0)
    ros.spin_until(lambda: calls == [51.0])


def test_a_wall_timer_ignores_simulated_time(ros, simulated):
    node, _ = simulated
    calls = []
    steady = Clock(clock_type=ClockType.STEADY_TIME)
    node.create_timer(0.005, lambda: calls.append(1), clock=steady)
    ros.spin_until(lambda: calls)


def test_simulated_time_can_be_switched_at_run_time(node):
    assert not node.get_clock().ros_time_is_active
    assert node.set_parameters([Parameter("use_sim_time", value=True)])[0].successful
    assert node.get_clock().now().nanoseconds == 0
    assert node.set_parameters([Parameter("use_sim_time", value=False)])[0].successful
    assert node.get_clock().now().nanoseconds > 0


def test_use_sim_time_must_be_a_bool(node):
    assert node.get_parameter("use_sim_time").value is False
    result = node.set_parameters([Parameter("use_sim_time", value=3)])[0]
    assert not result.successful
    assert not node.get_clock().ros_time_is_active


def test_a_simulated_timer_does_not_fire_while_time_stands(ros, simulated):
    node, set_time = simulated
    set_time(5.0)
    calls = []
    timer = node.create_timer(0.001, lambda: calls.append(1))
    ros.spin_for(0.02)
    assert not calls
    assert timer.time_until_next_call() == SECOND // 1000


def test_the_clock_of_the_node_tells_of_jumps(simulated):
    node, set_time = simulated
    jumps = []
    threshold = JumpThreshold(min_forward=Duration(seconds=5), min_backward=Duration(seconds=-5))
    with node.get_clock().create_jump_callback(threshold, post_callback=jumps.append):
        for seconds in (10.0, 12.0, 1.0):
            set_time(seconds)
        node.set_parameters([Parameter("use_sim_time", value=False)])
    assert [jump.clock_change for jump in jumps] == [
        ClockChange.ROS_TIME_NO_CHANGE,
        ClockChange.ROS_TIME_NO_CHANGE,
        ClockChange.ROS_TIME_DEACTIVATED,
    ]
    assert [jump.delta.nanoseconds for jump in jumps[:2]] == [10 * SECOND, -11 * SECOND]


def test_there_is_a_subscription_while_time_is_simulated(ros, node):
    assert node.count_subscribers("/clock") == 0
    node.set_parameters([Parameter("use_sim_time", value=True)])
    ros.wait_until(lambda: node.count_subscribers("/clock") == 1)
    node.set_parameters([Parameter("use_sim_time", value=False)])
    ros.wait_until(lambda: node.count_subscribers("/clock") == 0)
