"""Reading messages of rosbags, which need no ROS, and refusing malformed ones."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore

from bdt_msgs_py.reading import (
    NEVER,
    nanoseconds_from_seconds,
    nanoseconds_from_stamp,
    read_position,
    read_samples,
    read_voltage,
)

COLUMNS = ("t[s]", "u[V]", "q3[m]")
LABEL = "t[s],u[V],q3[m]"
TYPES = get_typestore(Stores.ROS2_JAZZY).types
Time = TYPES["builtin_interfaces/msg/Time"]
Header = TYPES["std_msgs/msg/Header"]
JointState = TYPES["sensor_msgs/msg/JointState"]
Dimension = TYPES["std_msgs/msg/MultiArrayDimension"]
Layout = TYPES["std_msgs/msg/MultiArrayLayout"]
Samples = TYPES["std_msgs/msg/Float64MultiArray"]


def joint_state(names=("motor",), position=(), effort=(), stamp=(3, 5)):
    return JointState(
        Header(Time(*stamp), ""),
        list(names),
        np.array(position, dtype=float),
        np.empty(0),
        np.array(effort, dtype=float),
    )


def samples(data, count, label=LABEL, width=3, offset=0):
    """Return a Float64MultiArray as rosbags reads it."""
    dimensions = [Dimension("sample", count, count * width), Dimension(label, width, width)]
    return Samples(Layout(dimensions, offset), np.asarray(data, dtype=float))


def test_a_stamp_is_an_integer_number_of_nanoseconds():
    # As a float64 this time would be a quarter of a microsecond off.
    assert nanoseconds_from_stamp(Time(1_763_680_000, 999_999_999)) == 1_763_680_000_999_999_999


def test_never_is_the_latest_second_that_a_stamp_can_hold():
    assert nanoseconds_from_stamp(Time(2**31 - 1, 0)) == NEVER


@given(st.integers(0, 10**9), st.sampled_from([500, 5000, 3000]))
def test_the_time_of_a_row_becomes_the_nearest_nanosecond(sample, rate):
    nearest = (2 * sample * 10**9 + rate) // (2 * rate)
    # Two days and more of seconds resolve 3e-11 s in a float64.
    assert abs(nanoseconds_from_seconds(sample / rate) - nearest) <= (sample / rate > 1e5)


def test_a_position_comes_with_its_stamp():
    message = joint_state(["platform_3"], position=[0.25])
    assert read_position(message, "platform_3") == (3_000_000_005, 0.25)


def test_a_voltage_comes_from_the_effort_of_the_motor():
    assert read_voltage(joint_state(["motor"], effort=[-12.5])) == (3_000_000_005, -12.5)


def test_what_is_read_are_plain_numbers():
    stamp, position = read_position(joint_state(["gap"], position=[0.25]), "gap")
    assert type(stamp) is int
    assert type(position) is float


def test_a_joint_is_found_among_those_of_a_whole_robot():
    message = joint_state(["arm", "platform_3", "motor"], position=[1.0, 0.25, 2.0])
    assert read_position(message, "platform_3")[1] == 0.25
    assert read_voltage(joint_state(["arm", "motor"], effort=[1.0, 3.0]))[1] == 3.0


@pytest.mark.parametrize(
    ("names", "position"),
    [
        (["motor"], [0.25]),
        ([], [0.25]),
        (["platform_3", "platform_2"], [0.25]),
        (["platform_3", "platform_3"], [0.25, 0.5]),
        (["platform_3"], []),
        (["platform_3"], [0.25, 0.5]),
        (["Platform_3"], [0.25]),
    ],
)
def test_a_position_that_is_not_there_once_is_refused(names, position):
    text = (
        r"^JointState with names .* and \d position values: must have the joint platform_3 once "
        "and one position for each joint$"
    )
    with pytest.raises(ValueError, match=text):
        read_position(joint_state(names, position=position), "platform_3")


@pytest.mark.parametrize(
    ("names", "effort"),
    [(["platform_3"], [1.0]), (["motor"], []), (["motor"], [1.0, 2.0]), ([], [])],
)
def test_a_voltage_of_anything_but_the_motor_is_refused(names, effort):
    text = (
        r"^JointState with names .* and \d effort values: must have the joint motor once "
        "and one effort for each joint$"
    )
    with pytest.raises(ValueError, match=text):
        read_voltage(joint_state(names, effort=effort))


def test_a_position_is_no_voltage():
    with pytest.raises(ValueError, match="0 effort values"):
        read_voltage(joint_state(["motor"], position=[1.0]))


def test_samples_are_rows_of_columns():
    rows = read_samples(samples(range(6), 2), COLUMNS)
    assert rows.dtype == np.float64
    assert rows.tolist() == [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]


def test_samples_are_not_copied():
    message = samples(range(6), 2)
    assert np.shares_memory(read_samples(message, COLUMNS), message.data)


def test_no_samples_are_no_rows():
    assert read_samples(samples([], 0), COLUMNS).shape == (0, 3)


def test_samples_begin_at_the_data_offset():
    assert read_samples(samples(range(5), 1, offset=2), COLUMNS).tolist() == [[2.0, 3.0, 4.0]]


def test_strides_and_the_label_of_the_rows_are_not_read():
    message = samples(range(6), 2)
    message.layout.dim[0].label, message.layout.dim[0].stride = "", 0
    message.layout.dim[1].stride = 0
    np.testing.assert_array_equal(read_samples(message, COLUMNS), np.arange(6.0).reshape(2, 3))


@pytest.mark.parametrize(
    "label", ["", "t[s],u[V]", "u[V],t[s],q3[m]", "t[s],u[V],q3[mm]", "t[s], u[V], q3[m]"]
)
def test_other_columns_are_refused(label):
    with pytest.raises(ValueError, match=r"^sample columns '.*': must be 't\[s\],u\[V\],q3\[m\]'$"):
        read_samples(samples(range(6), 2, label=label), COLUMNS)


@pytest.mark.parametrize("dimensions", [0, 1, 3])
def test_another_number_of_dimensions_is_refused(dimensions):
    layout = Layout([Dimension(",".join(COLUMNS), 3, 3)] * dimensions, 0)
    with pytest.raises(ValueError, match=r"^sample columns '': must be"):
        read_samples(Samples(layout, np.zeros(3)), COLUMNS)


@pytest.mark.parametrize(
    ("values", "count", "width", "offset"),
    [
        (6, 3, 3, 0),
        (6, 1, 3, 0),
        (5, 2, 3, 0),
        (7, 2, 3, 0),
        (6, 3, 2, 0),
        (6, 2, 4, 0),
        (6, 2, 3, 1),
        (0, 1, 3, 0),
        (0, 0, 3, 3),
    ],
)
def test_sizes_that_do_not_fit_the_data_are_refused(values, count, width, offset):
    text = rf"^{values} values with offset {offset}: must be {count} rows of 3 columns$"
    with pytest.raises(ValueError, match=text):
        read_samples(samples(np.zeros(values), count, width=width, offset=offset), COLUMNS)
