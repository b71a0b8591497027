"""Times and durations."""

import pytest
from builtin_interfaces.msg import Duration as DurationMsg
from builtin_interfaces.msg import Time as TimeMsg
from rclpy.clock import ClockType
from rclpy.constants import S_TO_NS
from rclpy.duration import Duration, Infinite
from rclpy.time import Time


def test_times_are_made_of_seconds_and_nanoseconds():
    assert Time().nanoseconds == 0
    assert Time(seconds=1, nanoseconds=5).nanoseconds == S_TO_NS + 5
    assert Time(seconds=1.5).nanoseconds == 1_500_000_000
    assert Time(seconds=3, nanoseconds=7).seconds_nanoseconds() == (3, 7)
    assert Time().clock_type == ClockType.SYSTEM_TIME
    assert repr(Time(nanoseconds=1, clock_type=ClockType.STEADY_TIME)) == (
        "Time(nanoseconds=1, clock_type=STEADY_TIME)"
    )


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ({"clock_type": "SYSTEM_TIME"}, TypeError),
        ({"seconds": -1}, ValueError),
        ({"nanoseconds": -1}, ValueError),
        ({"nanoseconds": 2**63}, OverflowError),
        ({"seconds": 1e10}, OverflowError),
    ],
)
def test_times_that_cannot_be(arguments, error):
    with pytest.raises(error):
        Time(**arguments)


def test_durations_may_be_negative():
    assert Duration(seconds=-1.5).nanoseconds == -1_500_000_000
    assert Duration(seconds=1, nanoseconds=-1).nanoseconds == S_TO_NS - 1
    assert repr(Duration(nanoseconds=3)) == "Duration(nanoseconds=3)"
    assert str(Duration(nanoseconds=3)) == "3 nanoseconds"
    assert str(Infinite) == "Infinite"
    with pytest.raises(OverflowError):
        Duration(nanoseconds=2**63)
    with pytest.raises(OverflowError):
        Duration(nanoseconds=-(2**63) - 1)


def test_times_and_durations_calculate():
    later = Time(seconds=3) + Duration(seconds=1.5)
    assert later.nanoseconds == 4_500_000_000
    assert Duration(seconds=1.5) + Time(seconds=3) == later
    assert later - Time(seconds=5) == Duration(seconds=-0.5)
    assert (later - Duration(nanoseconds=1)).seconds_nanoseconds() == (4, 499_999_999)
    kept = Time(seconds=1, clock_type=ClockType.ROS_TIME) + Duration(seconds=1)
    assert kept.clock_type == ClockType.ROS_TIME
    with pytest.raises(ValueError, match="negative time"):
        Time(seconds=1) - Duration(seconds=3)
    with pytest.raises(OverflowError):
        Time(nanoseconds=2**63 - 1) + Duration(nanoseconds=1)
    for wrong in (lambda: Time() + Time(), lambda: Time() - 1, lambda: Time() + 1.0):
        with pytest.raises(TypeError):
            wrong()


def test_times_compare():
    early, late = Time(seconds=1), Time(seconds=2)
    assert early < late
    assert early <= late
    assert late > early
    assert late >= early
    assert early == Time(nanoseconds=S_TO_NS)
    assert early != late
    assert early != 1
    with pytest.raises(TypeError):
        _ = early < 5


def test_times_of_different_clocks_do_not_compare():
    for compare in ("__lt__", "__le__", "__gt__", "__ge__", "__eq__"):
        with pytest.raises(TypeError, match="different clock types"):
            getattr(Time(), compare)(Time(clock_type=ClockType.ROS_TIME))
    with pytest.raises(TypeError, match="different clock types"):
        Time() - Time(clock_type=ClockType.STEADY_TIME)


def test_durations_compare():
    short, long = Duration(seconds=1), Duration(seconds=2)
    assert short < long
    assert short <= long
    assert long > short
    assert long >= short
    assert short == Duration(nanoseconds=S_TO_NS)
    assert short != long
    assert short != 1
    with pytest.raises(TypeError):
        _ = short > 1.0


def test_messages_are_made_and_read():
    assert Time(seconds=1, nanoseconds=2).to_msg() == TimeMsg(sec=1, nanosec=2)
    assert Time.from_msg(TimeMsg(sec=1, nanosec=2)).nanoseconds == S_TO_NS + 2
    assert Time.from_msg(TimeMsg()).clock_type == ClockType.ROS_TIME
    assert Time.from_msg(TimeMsg(), ClockType.SYSTEM_TIME).clock_type == ClockType.SYSTEM_TIME
    assert Duration(seconds=-1.5).to_msg() == DurationMsg(sec=-2, nanosec=500_000_000)
    assert Duration.from_msg(DurationMsg(sec=-2, nanosec=500_000_000)) == Duration(seconds=-1.5)
    with pytest.raises(TypeError):
        Time.from_msg(DurationMsg())
    with pytest.raises(TypeError):
        Duration.from_msg(TimeMsg())


def test_times_are_not_hashable():
    for value in (Time(), Duration()):
        with pytest.raises(TypeError, match="unhashable"):
            hash(value)


@pytest.mark.parametrize("value", [Time(seconds=1), Duration(seconds=-1)])
def test_classes_say_where_programs_find_them(value):
    assert type(value).__module__ == f"rclpy.{type(value).__name__.lower()}"
