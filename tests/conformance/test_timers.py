"""Timers and rates in wall time."""

import threading
import time

import pytest
from rclpy._rclpy_pybind11 import RCLError
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock, ClockType, ROSClock
from rclpy.exceptions import InvalidHandle, ROSInterruptException
from rclpy.executors import ExternalShutdownException
from rclpy.time import Time

SECOND = 10**9


@pytest.mark.parametrize("clock_type", [ClockType.SYSTEM_TIME, ClockType.STEADY_TIME, None])
def test_a_timer_calls_back_periodically(ros, node, clock_type):
    clock = Clock(clock_type=clock_type) if clock_type else None
    calls = []
    start = time.monotonic()
    node.create_timer(0.01, lambda: calls.append(time.monotonic() - start), clock=clock)
    ros.spin_until(lambda: len(calls) == 5)
    assert all(call >= 0.01 * (1 + index) - 1e-3 for index, call in enumerate(calls))


def test_a_timer_tells_its_properties(node):
    def callback():
        pass

    group, clock = ReentrantCallbackGroup(), Clock(clock_type=ClockType.STEADY_TIME)
    timer = node.create_timer(0.5, callback, callback_group=group, clock=clock)
    assert timer.timer_period_ns == SECOND // 2
    assert timer.callback is callback
    assert timer.callback_group is group
    assert timer.clock is clock
    assert list(node.timers) == [timer]
    assert node.create_timer(1, callback).clock is node.get_clock()


def test_a_timer_tells_when_it_is_due(node):
    timer = node.create_timer(3600.0, print)
    assert not timer.is_ready()
    assert 0 < timer.time_until_next_call() <= 3600 * SECOND
    assert 0 <= timer.time_since_last_call() < 60 * SECOND
    due = node.create_timer(0.0, print)
    assert due.is_ready()
    assert due.time_until_next_call() <= 0


def test_a_timer_that_destroys_itself_fires_once(ros, node):
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


def test_a_canceled_timer_rests_until_it_is_reset(ros, node):
    calls = []
    timer = node.create_timer(0.01, lambda: calls.append(1))
    assert not timer.is_canceled()
    timer.cancel()
    assert timer.is_canceled()
    assert not timer.is_ready()
    ros.spin_for(0.03)
    assert not calls
    timer.reset()
    assert not timer.is_canceled()
    ros.spin_until(lambda: calls)


def test_a_timer_need_not_start_by_itself(ros, node):
    calls = []
    timer = node.create_timer(0.01, lambda: calls.append(1), autostart=False)
    assert timer.is_canceled()
    assert timer.time_until_next_call() is None
    ros.spin_for(0.03)
    assert not calls
    timer.reset()
    ros.spin_until(lambda: calls)


def test_reset_starts_the_period_anew(node):
    timer = node.create_timer(60.0, print)
    while timer.time_until_next_call() > 59.9 * SECOND:
        time.sleep(0.001)
    before = time.monotonic_ns()
    timer.reset()
    left = timer.time_until_next_call()
    # However long a busy machine holds this process up.
    assert left >= 60 * SECOND - (time.monotonic_ns() - before)


def test_a_timer_may_cancel_itself(ros, node):
    calls = []

    def once():
        calls.append(1)
        timer.cancel()

    timer = node.create_timer(0.001, once)
    ros.spin_until(lambda: calls)
    ros.spin_for(0.02)
    assert calls == [1]


def test_a_late_timer_leaves_calls_out(ros, node):
    calls = []
    timer = node.create_timer(0.1, lambda: calls.append(1))
    while timer.time_until_next_call() > -SECOND // 2:
        time.sleep(0.001)
    before = time.monotonic_ns()
    ros.executor.spin_once(timeout_sec=1)
    left = timer.time_until_next_call()
    # Were no call left out, it would be late by 0.4 s.
    assert left > -(time.monotonic_ns() - before)
    assert calls == [1]


def test_the_period_can_change(ros, node):
    calls = []
    timer = node.create_timer(0.001, lambda: calls.append(1))
    timer.timer_period_ns = 3600 * SECOND
    assert timer.timer_period_ns == 3600 * SECOND
    ros.spin_until(lambda: calls)  # the period that had begun
    ros.spin_for(0.02)
    assert calls == [1]
    timer.reset()
    assert timer.time_until_next_call() > 3000 * SECOND


def test_periods_must_not_be_negative(node):
    with pytest.raises(RCLError, match="must be non-negative"):
        node.create_timer(-1.0, print)


def test_a_timer_is_destroyed_once(node):
    timer = node.create_timer(1.0, print)
    assert node.destroy_timer(timer)
    assert not node.destroy_timer(timer)
    assert list(node.timers) == []
    for use in (timer.cancel, timer.reset, timer.is_canceled, timer.time_until_next_call):
        with pytest.raises(InvalidHandle):
            use()


@pytest.fixture
def spinning(ros, node):
    """Let another thread spin the node."""

    def spin():
        try:
            ros.executor.spin()
        except ExternalShutdownException:
            return

    spinner = threading.Thread(target=spin)
    spinner.start()
    yield node
    ros.executor.shutdown()
    spinner.join(20)
    assert not spinner.is_alive()


def test_a_rate_sleeps_in_step(spinning):
    rate = spinning.create_rate(100.0)
    start = time.monotonic()
    for _ in range(5):
        rate.sleep()
    assert time.monotonic() - start > 0.035
    assert spinning.destroy_rate(rate)
    with pytest.raises((RuntimeError, InvalidHandle)):
        rate.sleep()


def test_a_call_that_nobody_slept_for_ends_the_next_sleep_at_once(ros, spinning):
    clock, calls = ROSClock(), []
    clock._set_ros_time_is_active(True)
    clock.set_ros_time_override(Time(seconds=10, clock_type=ClockType.ROS_TIME))
    rate = spinning.create_rate(1.0, clock)
    # Made later, so it is called after the timer of the rate.
    spinning.create_timer(1.0, lambda: calls.append(1), clock=clock)
    clock.set_ros_time_override(Time(seconds=11.5, clock_type=ClockType.ROS_TIME))
    ros.wait_until(lambda: calls)
    sleeps = [threading.Thread(target=rate.sleep, daemon=True) for _ in range(2)]
    sleeps[0].start()
    sleeps[0].join(20)
    assert not sleeps[0].is_alive()
    sleeps[1].start()
    sleeps[1].join(0.05)
    assert sleeps[1].is_alive()
    spinning.destroy_rate(rate)
    sleeps[1].join(20)
    assert not sleeps[1].is_alive()


def test_a_rate_is_interrupted_by_shutdown(ros, spinning):
    slow = spinning.create_rate(0.01)
    threading.Timer(0.05, ros.context.try_shutdown).start()
    with pytest.raises(ROSInterruptException):
        slow.sleep()
    with pytest.raises(ROSInterruptException):
        slow.sleep()


def test_a_rate_ends_with_its_destruction(spinning):
    slow = spinning.create_rate(0.01)
    threading.Timer(0.05, spinning.destroy_rate, [slow]).start()
    start = time.monotonic()
    slow.sleep()
    assert time.monotonic() - start < 10


@pytest.mark.parametrize("frequency", [0, -1.0])
def test_rates_are_positive(node, frequency):
    with pytest.raises(ValueError, match="frequency must be > 0"):
        node.create_rate(frequency)
