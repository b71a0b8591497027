"""Every field of every message from outside: what is accepted, and why what is not is refused."""

import math
from array import array

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from hypothesis import given
from hypothesis import strategies as st
from rcl_interfaces.msg import ParameterValue
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, TimeReference
from std_msgs.msg import Float64MultiArray, Header, MultiArrayDimension, MultiArrayLayout

from bdt_msgs_py import message_checks as checks
from bdt_msgs_py.rejection import MessageRejectedError, Reason
from bdt_msgs_py.topics import TELEMETRY_COLUMNS
from bdt_msgs_py.writing import gap_estimate, motor_voltage, platform_position, sample_message

ANY_FLOAT = st.floats(width=64)
ANY_TEXT = st.text(max_size=5) | st.sampled_from(["platform_3", "motor", "backlash_gap"])
TIMES = st.builds(Time, sec=st.integers(-(2**31), 2**31 - 1), nanosec=st.integers(0, 2**32 - 1))
ARRAYS = st.lists(ANY_FLOAT, max_size=3).map(lambda values: array("d", values))
JOINT_STATES = st.builds(
    JointState,
    header=st.builds(Header, stamp=TIMES, frame_id=ANY_TEXT),
    name=st.lists(ANY_TEXT, max_size=3),
    position=ARRAYS,
    velocity=ARRAYS,
    effort=ARRAYS,
)
SIZES = st.integers(0, 4) | st.integers(0, 2**32 - 1)
DIMENSIONS = st.builds(
    MultiArrayDimension,
    label=st.sampled_from([",".join(TELEMETRY_COLUMNS), "sample", ""]),
    size=SIZES,
    stride=SIZES,
)
SAMPLES = st.builds(
    Float64MultiArray,
    layout=st.builds(MultiArrayLayout, dim=st.lists(DIMENSIONS, max_size=3), data_offset=SIZES),
    data=st.lists(ANY_FLOAT, max_size=9).map(lambda values: array("d", values)),
)


def passes(check, message):
    """Return what a check gives, None if it rejects the message; any other error leaves."""
    try:
        return check(message)
    except MessageRejectedError as error:
        reason, text = error.reason, str(error)
    assert isinstance(reason, Reason)
    assert text
    assert "\n" not in text
    return None


@given(JOINT_STATES)
def test_whatever_a_joint_state_holds_it_is_numbers_or_a_rejection(message):
    for check in (checks.check_position, checks.check_estimate):
        if (taken := passes(check, message)) is not None:
            assert taken[0] >= 0
            assert abs(taken[1]) <= checks.LARGEST_POSITION
    if (command := passes(checks.check_command, message)) is not None:
        assert math.isfinite(command.voltage)


@given(SAMPLES)
def test_whatever_telemetry_holds_it_is_rows_or_a_rejection(message):
    rows = passes(checks.check_telemetry_times, message)
    if rows is not None:
        assert len(rows) >= 1
        assert (np.diff(rows[:, 0]) > 0).all()
        assert rows[0, 0] >= 0
        passes(checks.check_telemetry_values, rows)


@given(TIMES, TIMES, ANY_TEXT)
def test_whatever_a_clock_or_progress_holds_it_is_times_or_a_rejection(first, second, name):
    clock = passes(checks.check_clock, Clock(clock=first))
    assert clock is None or clock >= 0
    told = TimeReference(header=Header(stamp=first), time_ref=second, source=name)
    progress = passes(checks.check_progress, told)
    assert progress is None or min(progress[1:]) >= 0


def test_what_the_project_writes_passes():
    assert checks.check_position(platform_position(5, 0.25)) == (5, 0.25)
    assert checks.check_command(motor_voltage(5, -12.0, "/c")) == (5, -12.0, "/c")
    assert checks.check_estimate(gap_estimate(5, 0.1, math.nan, 0.0)) == (5, 0.1)
    rows = np.array([[0.0, 1.0, 2.0], [2e-4, 1.0, 2.0]])
    np.testing.assert_array_equal(
        checks.check_telemetry_times(sample_message(rows, TELEMETRY_COLUMNS)), rows
    )


@pytest.mark.parametrize(
    ("position", "stamp", "reason", "says"),
    [
        (math.nan, 0, Reason.NOT_FINITE, "position nan m: must be finite"),
        (1e300, 0, Reason.RANGE, r"position 1e\+300 m: must be -1000 to 1000 m"),
        (0.0, -1, Reason.STAMP, "stamp -1 s and 999999999 ns: must be 0 s or later"),
    ],
)
def test_a_position_that_is_none_is_refused(position, stamp, reason, says):
    with pytest.raises(MessageRejectedError, match=says) as caught:
        checks.check_position(platform_position(stamp, position))
    assert caught.value.reason is reason


def test_a_second_of_nanoseconds_is_refused():
    with pytest.raises(MessageRejectedError, match="below 1e9 ns"):
        checks.check_clock(Clock(clock=Time(sec=1, nanosec=10**9)))


@pytest.mark.parametrize(
    ("times", "reason", "says"),
    [
        ([], Reason.LAYOUT, "0 rows"),
        ([3e9], Reason.RANGE, r"time 3e\+09 s: must be 0 to"),
        ([-1.0], Reason.RANGE, "time -1 s"),
        ([math.nan, 1.0], Reason.NOT_FINITE, "time nan s: must be finite"),
        ([1.0, math.nan, 2.0], Reason.TIME, "time nan s in row 1"),
        ([1.0, 1.0], Reason.TIME, "time 1.0 s in row 1: must be after that of the row before"),
    ],
)
def test_telemetry_whose_times_are_none_is_refused(times, reason, says):
    rows = np.array([[time, 0.0, 0.0] for time in times]).reshape(-1, 3)
    with pytest.raises(MessageRejectedError, match=says) as caught:
        checks.check_telemetry_times(sample_message(rows, TELEMETRY_COLUMNS))
    assert caught.value.reason is reason


@pytest.mark.parametrize(
    ("row", "says"),
    [
        ([0.0, 1e300, 0.0], r"row 0: motor voltage 1e\+300 V: must be"),
        ([0.0, 0.0, math.nan], "row 0: position nan m: must be finite"),
        ([0.0, -math.inf, 0.0], "row 0: motor voltage -inf V: must be finite"),
    ],
)
def test_telemetry_of_no_machine_is_refused(row, says):
    with pytest.raises(MessageRejectedError, match=says):
        checks.check_telemetry_values(np.array([row]))


@pytest.mark.parametrize(
    "value",
    [
        ParameterValue(type=1, bool_value=True),
        ParameterValue(type=3, double_value=math.nan),
        ParameterValue(type=3, double_value=-1.0),
    ],
)
def test_a_dead_zone_that_is_none_is_refused(value):
    with pytest.raises(MessageRejectedError, match="dead_zone_tolerance"):
        checks.check_dead_zone(value)
