"""Clocks, timers, simulated time."""

import threading
import time

import pytest
from builtin_interfaces.msg import Time as TimeMsg
from rclpy._rclpy_pybind11 import RCLError
from rclpy.clock import Clock, ClockChange, ClockType, JumpThreshold, ROSClock
from rclpy.duration import Duration
from rclpy.exceptions import InvalidHandle, ROSInterruptException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.time import Time
from rosgraph_msgs.msg import Clock as ClockMsg

SECOND = 10**9


def test_times_and_durations_calculate():
    later = Time(seconds=3) + Duration(seconds=1.5)
    assert later.nanoseconds == 4_500_000_000
    assert later - Time(seconds=5) == Duration(seconds=-0.5)
    assert (later - Duration(nanoseconds=1)).seconds_nanoseconds() == (4, 499_999_999)
    assert Time.from_msg(TimeMsg(sec=1, nanosec=2)).to_msg() == TimeMsg(sec=1, nanosec=2)
    assert Duration(seconds=-1.5).to_msg().sec == -2
    with pytest.raises(ValueError, match="negative time"):
        Time(seconds=1) - Duration(seconds=3)
    with pytest.raises(OverflowError):
        Time(seconds=1e10)


def test_times_of_different_clocks_do_not_compare():
    with pytest.raises(TypeError, match="different clock types"):
        _ = Time() < Time(clock_type=ClockType.ROS_TIME)
    with pytest.raises(TypeError, match="different clock types"):
        Time() - Time(clock_type=ClockType.STEADY_TIME)


def test_clock_types():
    assert isinstance(Clock(clock_type=ClockType.ROS_TIME), ROSClock)
    assert not isinstance(Clock(), ROSClock)
    assert abs(Clock().now().nanoseconds - time.time_ns()) < SECOND
    steady = Clock(clock_type=ClockType.STEADY_TIME)
    assert steady.now() <= steady.now()
    assert repr(ROSClock()) == "Clock(clock_type=ROS_TIME)"


def test_jump_callbacks_see_the_jumps_they_ask_for():
    clock = ROSClock()
    jumps = []
    threshold = JumpThreshold(min_forward=Duration(seconds=1), min_backward=Duration(seconds=-1))
    with clock.create_jump_callback(threshold, post_callback=jumps.append):
        clock._set_ros_time_is_active(True)
        for seconds in (10, 10.5, 20, 19.5, 5):
            clock.set_ros_time_override(Time(seconds=seconds, clock_type=ClockType.ROS_TIME))
    clock._set_ros_time_is_active(False)
    assert [jump.clock_change for jump in jumps] == [ClockChange.ROS_TIME_ACTIVATED] + [
        ClockChange.ROS_TIME_NO_CHANGE
    ] * 3
    assert [jump.delta.nanoseconds / 1e9 for jump in jumps[1:]] == [10.0, 9.5, -14.5]


@pytest.mark.parametrize("clock_type", [ClockType.SYSTEM_TIME, ClockType.STEADY_TIME, None])
def test_a_timer_calls_back_periodically(ros, clock_type):
    node = ros.create(Node, "n")
    clock = Clock(clock_type=clock_type) if clock_type else None
    calls = []
    start = time.monotonic()
    node.create_timer(0.01, lambda: calls.append(time.monotonic() - start), clock=clock)
    ros.spin_until(lambda: len(calls) == 5)
    assert all(call >= 0.01 * (1 + index) - 1e-3 for index, call in enumerate(calls))


def test_a_timer_that_destroys_itself_fires_once(ros):
    node = ros.create(Node, "n")
    calls = []

    def once():
        calls.append(1)
        node.destroy_timer(timer)

    timer = node.create_timer(0.0, once)
    ros.spin_until(lambda: calls)
    ros.spin_for(0.03)
    assert calls == [1]
    with pytest.raises(InvalidHandle):
        timer.is_ready()


def test_a_canceled_timer_rests_until_it_is_reset(ros):
    node = ros.create(Node, "n")
    calls = []
    timer = node.create_timer(0.01, lambda: calls.append(1), autostart=False)
    assert timer.is_canceled()
    assert timer.time_until_next_call() is None
    ros.spin_for(0.03)
    assert not calls
    timer.reset()
    ros.spin_until(lambda: calls)
    timer.cancel()
    assert timer.is_canceled()
    assert timer.timer_period_ns == SECOND // 100
    with pytest.raises(RCLError, match="must be non-negative"):
        node.create_timer(-1.0, print)


@pytest.fixture
def simulated(ros):
    node = ros.create(Node, "simulated", use_sim_time=True)
    source = ros.create(Node, "source")
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


def test_simulated_time_can_be_switched_at_run_time(ros):
    node = ros.create(Node, "n")
    assert not node.get_clock().ros_time_is_active
    assert node.set_parameters([Parameter("use_sim_time", value=True)])[0].successful
    assert node.get_clock().now().nanoseconds == 0
    assert node.set_parameters([Parameter("use_sim_time", value=False)])[0].successful
    assert node.get_clock().now().nanoseconds > 0


def test_sleeping_follows_the_clock(ros):
    clock = Clock(clock_type=ClockType.STEADY_TIME)
    start = clock.now()
    assert clock.sleep_for(Duration(seconds=0.02), context=ros.context)
    assert clock.now() - start >= Duration(seconds=0.02)
    threading.Timer(0.05, ros.context.try_shutdown).start()
    assert not clock.sleep_for(Duration(seconds=60), context=ros.context)


def test_a_rate_sleeps_in_step_and_is_interrupted_by_shutdown(ros):
    node = ros.create(Node, "n")
    rate = node.create_rate(100.0)
    spinner = threading.Thread(target=_spin_quietly, args=(ros.executor,))
    spinner.start()
    start = time.monotonic()
    for _ in range(5):
        rate.sleep()
    assert time.monotonic() - start > 0.035
    threading.Timer(0.05, ros.context.try_shutdown).start()
    slow = node.create_rate(0.01)
    with pytest.raises(ROSInterruptException):
        slow.sleep()
    spinner.join(5)


def _spin_quietly(executor):
    from rclpy.executors import ExternalShutdownException

    try:
        executor.spin()
    except ExternalShutdownException:
        return
