"""What simulated time and timers promise below rclpy, and stamps that cannot be."""

import pytest
from builtin_interfaces.msg import Time as TimeMsg
from embedded_ros.alarm import Alarm
from embedded_ros.simulated_time import SimulatedTime
from embedded_ros.time_jumps import ClockChange
from embedded_ros.timeline import SimulatedTimeline, Timeline
from hypothesis import given
from hypothesis import strategies as st
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMsg


def test_a_stamp_before_the_epoch_is_left_out_with_a_warning(ros, capfd):
    # rclpy 7.1 lets the ValueError out of the executor, which ends the node.
    node = ros.create(Node, "simulated", use_sim_time=True)
    publisher = ros.create(Node, "source").create_publisher(ClockMsg, "/clock", 10)
    for seconds in (5, -1, -(2**31)):
        publisher.publish(ClockMsg(clock=TimeMsg(sec=seconds, nanosec=1)))
        ros.spin_for(0.02)
    assert node.get_clock().now().nanoseconds == 5 * 10**9 + 1
    assert "/clock is left out: Seconds value must not be negative" in capfd.readouterr().err
    publisher.publish(ClockMsg(clock=TimeMsg(sec=6)))
    ros.spin_until(lambda: node.get_clock().now().nanoseconds == 6 * 10**9)


def test_timelines_of_a_source_show_the_same():
    source, first, second = SimulatedTime(), SimulatedTimeline(), SimulatedTimeline()
    source.drive(first)
    source.tell(7)
    source.show(True)
    source.drive(second)
    assert (first.read(), second.read()) == (7, 7)
    assert not first.passes
    source.show(False)
    assert first.passes
    assert first.read() > 7


class Jumps:
    """Notes the jumps that it is told of, and the time before each."""

    def __init__(self, timeline):
        self._timeline = timeline
        self.seen = []
        timeline.listeners.append(self)

    def concerns(self, change, delta):
        return delta != 0

    def before_jump(self):
        self._before = self._timeline.read()

    def after_jump(self, change, delta):
        self.seen.append((change, self._before, delta))


def test_listeners_hear_of_a_jump_before_and_after():
    timeline = SimulatedTimeline()
    timeline.set(100)
    timeline.simulate(True)
    jumps = Jumps(timeline)
    for moment in (150, 150, 120):
        timeline.set(moment)
    no_change = ClockChange.ROS_TIME_NO_CHANGE
    assert jumps.seen == [(no_change, 100, 50), (no_change, 150, -30)]


class Hand:
    """A clock that the test sets."""

    def __init__(self):
        self.now = 0
        self.timeline = Timeline(lambda: self.now)


@given(
    period=st.integers(1, 50),
    steps=st.lists(st.integers(0, 200), min_size=1, max_size=50),
)
def test_an_alarm_is_due_at_multiples_of_its_period_and_leaves_out_what_was_missed(period, steps):
    hand = Hand()
    alarm = Alarm(hand.timeline, period, lambda: None)
    due = period
    for step in steps:
        hand.now += step
        assert alarm.due_in() == max(0, due - hand.now)
        assert alarm.ring() == (hand.now >= due)
        if hand.now >= due:
            due = max(due + period, -(-hand.now // period) * period)
        assert alarm.time_left() == due - hand.now


def test_an_alarm_without_a_period_is_due_at_every_look():
    hand = Hand()
    alarm = Alarm(hand.timeline, 0, lambda: None)
    for hand.now in (0, 5, 5, 9):
        assert alarm.ring()


@pytest.mark.parametrize("closing", ["cancel", "close"])
def test_an_alarm_that_is_stopped_is_not_due(closing):
    hand = Hand()
    alarm = Alarm(hand.timeline, 10, lambda: None)
    getattr(alarm, closing)()
    hand.now = 20
    assert alarm.due_in() is None
    assert not alarm.ring()
    assert (alarm in hand.timeline.listeners) == (closing == "cancel")


def test_time_that_runs_backward_begins_the_period_anew():
    timeline, news = SimulatedTimeline(), []
    timeline.set(100)
    timeline.simulate(True)
    alarm = Alarm(timeline, 10, lambda: news.append(timeline.read()))
    timeline.set(50)
    assert (alarm.time_left(), news) == (10, [])
    timeline.set(60)
    assert (alarm.ring(), news) == (True, [60])
