"""Clocks, their jumps and sleeping on them."""

import threading
import time

import pytest
from rclpy.clock import Clock, ClockChange, ClockType, JumpThreshold, ROSClock, TimeJump
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.exceptions import NotInitializedException
from rclpy.time import Time

SECOND = 10**9


def ros_time(seconds):
    return Time(seconds=seconds, clock_type=ClockType.ROS_TIME)


def test_clock_types():
    assert isinstance(Clock(clock_type=ClockType.ROS_TIME), ROSClock)
    assert not isinstance(Clock(), ROSClock)
    assert Clock().clock_type == ClockType.SYSTEM_TIME
    assert Clock(clock_type=ClockType.STEADY_TIME).now().clock_type == ClockType.STEADY_TIME
    assert repr(ROSClock()) == "Clock(clock_type=ROS_TIME)"
    with pytest.raises(TypeError, match="ClockType enum"):
        Clock(clock_type="STEADY_TIME")


def test_clocks_show_the_time():
    assert abs(Clock().now().nanoseconds - time.time_ns()) < SECOND
    assert abs(ROSClock().now().nanoseconds - time.time_ns()) < SECOND
    steady = Clock(clock_type=ClockType.STEADY_TIME)
    assert steady.now() <= steady.now()


def test_a_simulated_clock_shows_what_it_is_set_to():
    clock = ROSClock()
    assert not clock.ros_time_is_active
    clock.set_ros_time_override(ros_time(5))
    assert clock.now() > ros_time(1000)
    clock._set_ros_time_is_active(True)
    assert clock.ros_time_is_active
    assert clock.now() == ros_time(5)
    with pytest.raises(TypeError):
        clock.set_ros_time_override(5)


def test_jump_callbacks_see_the_jumps_they_ask_for():
    clock = ROSClock()
    jumps = []
    threshold = JumpThreshold(min_forward=Duration(seconds=1), min_backward=Duration(seconds=-1))
    with clock.create_jump_callback(threshold, post_callback=jumps.append):
        clock._set_ros_time_is_active(True)
        for seconds in (10, 10.5, 20, 19.5, 5):
            clock.set_ros_time_override(ros_time(seconds))
    clock._set_ros_time_is_active(False)
    assert all(isinstance(jump, TimeJump) for jump in jumps)
    assert [jump.clock_change for jump in jumps] == [ClockChange.ROS_TIME_ACTIVATED] + [
        ClockChange.ROS_TIME_NO_CHANGE
    ] * 3
    assert [jump.delta.nanoseconds / 1e9 for jump in jumps[1:]] == [10.0, 9.5, -14.5]


def test_callbacks_come_before_and_after_a_jump_until_unregistered():
    clock = ROSClock()
    clock._set_ros_time_is_active(True)
    times = []
    handle = clock.create_jump_callback(
        JumpThreshold(min_forward=Duration(nanoseconds=1), min_backward=None),
        pre_callback=lambda: times.append(("before", clock.now())),
        post_callback=lambda _: times.append(("after", clock.now())),
    )
    clock.set_ros_time_override(ros_time(1))
    assert times == [("before", ros_time(0)), ("after", ros_time(1))]
    handle.unregister()
    handle.unregister()
    clock.set_ros_time_override(ros_time(2))
    assert len(times) == 2


def test_thresholds_and_callbacks_must_make_sense():
    forward, backward = Duration(seconds=1), Duration(seconds=-1)
    for arguments in (
        {"min_forward": backward, "min_backward": None},
        {"min_forward": None, "min_backward": forward},
        {"min_forward": Duration(), "min_backward": None},
        {"min_forward": None, "min_backward": None, "on_clock_change": False},
    ):
        with pytest.raises(ValueError):  # noqa: PT011 - the texts differ
            JumpThreshold(**arguments)
    threshold = JumpThreshold(min_forward=forward, min_backward=None)
    with pytest.raises(ValueError, match="must be callable"):
        ROSClock().create_jump_callback(threshold)
    with pytest.raises(ValueError, match="must be callable"):
        ROSClock().create_jump_callback(threshold, pre_callback=5)


@pytest.mark.parametrize("clock_type", list(ClockType)[1:])
def test_sleeping_takes_its_time(ros, clock_type):
    clock = Clock(clock_type=clock_type)
    start = clock.now()
    assert clock.sleep_for(Duration(seconds=0.02), context=ros.context)
    assert clock.now() - start >= Duration(seconds=0.02)
    assert clock.sleep_until(start, context=ros.context)


def test_sleeping_ends_with_the_context(ros):
    clock = Clock(clock_type=ClockType.STEADY_TIME)
    threading.Timer(0.05, ros.context.try_shutdown).start()
    assert not clock.sleep_for(Duration(seconds=60), context=ros.context)
    with pytest.raises(NotInitializedException):
        clock.sleep_for(Duration(seconds=60), context=ros.context)


def test_sleeping_needs_a_context_and_a_time_of_the_clock(ros):
    with pytest.raises(NotInitializedException):
        Clock().sleep_until(Clock().now(), context=Context())
    with pytest.raises(ValueError, match="clock type"):
        Clock().sleep_until(ros_time(1), context=ros.context)


def sleeper(clock, until, context):
    """Sleep in a thread; its result is put into the list that is returned."""
    result = []
    thread = threading.Thread(
        target=lambda: result.append(clock.sleep_until(until, context=context))
    )
    thread.start()
    return thread, result


def test_sleeping_follows_simulated_time(ros):
    clock = ROSClock()
    clock._set_ros_time_is_active(True)
    thread, result = sleeper(clock, ros_time(10), ros.context)
    clock.set_ros_time_override(ros_time(9))
    thread.join(0.05)
    assert thread.is_alive()
    clock.set_ros_time_override(ros_time(10))
    thread.join(20)
    assert result == [True]


def test_sleeping_ends_when_the_source_of_time_changes(ros):
    clock = ROSClock()
    clock._set_ros_time_is_active(True)
    thread, result = sleeper(clock, ros_time(10), ros.context)
    thread.join(0.05)
    clock._set_ros_time_is_active(False)
    thread.join(20)
    assert result == [False]


def test_a_change_of_the_source_is_a_jump_by_nothing():
    clock, jumps = ROSClock(), []
    clock.set_ros_time_override(Time(seconds=5, clock_type=ClockType.ROS_TIME))
    threshold = JumpThreshold(min_forward=None, min_backward=None)
    with clock.create_jump_callback(threshold, post_callback=jumps.append):
        clock._set_ros_time_is_active(True)
        clock._set_ros_time_is_active(True)
        clock._set_ros_time_is_active(False)
    assert [(jump.clock_change, jump.delta) for jump in jumps] == [
        (ClockChange.ROS_TIME_ACTIVATED, Duration()),
        (ClockChange.ROS_TIME_DEACTIVATED, Duration()),
    ]
