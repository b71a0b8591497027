"""Writing messages, read back by the readers and through the wire format."""

from array import array

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as st_numpy

from bdt_msgs_py.reading import (
    NEVER,
    nanoseconds_from_stamp,
    read_position,
    read_samples,
    read_voltage,
)
from bdt_msgs_py.topics import (
    DEAD_ZONE_JOINT,
    GAP_AGE_JOINT,
    GAP_JOINT,
    GAP_UNCERTAINTY_JOINT,
    VOLTAGE_OFFSET_JOINT,
)
from bdt_msgs_py.writing import (
    gap_estimate,
    motor_voltage,
    platform_position,
    progress,
    sample_message,
    stamp_from_nanoseconds,
)

COLUMNS = ("t[s]", "u[V]", "q3[m]")

stamps = st.integers(0, NEVER)
values = st.floats(allow_nan=False)


@given(stamps)
def test_a_stamp_keeps_every_nanosecond(nanoseconds):
    stamp = stamp_from_nanoseconds(nanoseconds)
    assert nanoseconds_from_stamp(stamp) == nanoseconds
    assert 0 <= stamp.nanosec < 1_000_000_000


@given(stamps, values)
def test_a_position_reads_back_as_written(stamp, position):
    assert read_position(platform_position(stamp, position), "platform_3") == (stamp, position)


@given(stamps, values, values, values)
def test_an_estimate_reads_back_as_written(stamp, gap, uncertainty, growth):
    message = gap_estimate(stamp, gap, uncertainty, growth)
    assert read_position(message, GAP_JOINT) == (stamp, gap)
    assert read_position(message, GAP_UNCERTAINTY_JOINT) == (stamp, uncertainty)
    assert message.velocity[0] == growth
    assert isinstance(message.position, array)


@given(stamps, values, values)
def test_an_estimate_reads_back_with_what_was_asked_for_because_of_it(stamp, age, tolerance):
    message = gap_estimate(stamp, 0.1, 0.01, 0.0, age, tolerance)
    assert read_position(message, GAP_JOINT) == (stamp, 0.1)
    assert read_position(message, GAP_AGE_JOINT) == (stamp, age)
    assert read_position(message, DEAD_ZONE_JOINT) == (stamp, tolerance)
    assert len(message.name) == len(message.position) == len(message.velocity)


def test_an_estimate_that_asks_for_nothing_has_no_joint_for_it():
    message = gap_estimate(0, 0.1, 0.01, 0.0)
    assert not {DEAD_ZONE_JOINT, VOLTAGE_OFFSET_JOINT} & set(message.name)
    assert not message.effort


@given(values, values)
def test_a_voltage_offset_that_is_asked_for_reads_back_as_written(tolerance, voltage):
    message = gap_estimate(5, 0.1, 0.01, 0.0, 0.2, tolerance, voltage)
    assert read_voltage(message, VOLTAGE_OFFSET_JOINT) == (5, voltage)
    assert read_position(message, DEAD_ZONE_JOINT) == (5, tolerance)
    assert len(message.name) == len(message.position) == len(message.velocity)


@given(stamps, values)
def test_a_voltage_reads_back_as_written(stamp, voltage):
    assert read_voltage(motor_voltage(stamp, voltage)) == (stamp, voltage)


@pytest.mark.parametrize(
    ("message", "used", "unused"),
    [
        (platform_position(0, 1.0), "position", ("velocity", "effort")),
        (motor_voltage(0, 1.0), "effort", ("position", "velocity")),
    ],
    ids=["position", "voltage"],
)
def test_a_joint_state_carries_one_number_and_nothing_else(message, used, unused):
    assert list(getattr(message, used)) == [1.0]
    assert isinstance(getattr(message, used), array)  # lists of floats are slow in rclpy
    assert [len(getattr(message, field)) for field in unused] == [0, 0]


def test_the_readers_refuse_each_other_s_messages():
    with pytest.raises(ValueError, match="must have the joint platform_3 once"):
        read_position(gap_estimate(0, 1.0, 0.1, 0.0), "platform_3")
    with pytest.raises(ValueError, match="must have the joint motor once"):
        read_voltage(platform_position(0, 1.0))


def test_progress_says_who_took_what_and_when_it_acts():
    message = progress("twin", 5_000_000_001, 7_000_000_002)
    assert message.source == "twin"
    assert nanoseconds_from_stamp(message.header.stamp) == 5_000_000_001
    assert nanoseconds_from_stamp(message.time_ref) == 7_000_000_002


def test_progress_without_plans_acts_never():
    assert nanoseconds_from_stamp(progress("twin", 0, None).time_ref) == NEVER


@given(st_numpy.arrays(np.float64, st.tuples(st.integers(0, 20), st.just(3))))
def test_samples_read_back_bit_for_bit(rows):
    """NaN included: to refuse it is the stream's job, not the message's."""
    read = read_samples(sample_message(rows, COLUMNS), COLUMNS)
    assert read.shape == rows.shape
    assert read.tobytes() == rows.tobytes()


@pytest.mark.parametrize(
    "rows",
    [np.arange(12.0).reshape(3, 4).T, np.arange(24.0).reshape(4, 6)[:, ::2], np.ones((4, 3), int)],
    ids=["transposed", "strided", "integers"],
)
def test_samples_of_any_memory_layout_are_written_row_by_row(rows):
    assert read_samples(sample_message(rows, COLUMNS), COLUMNS).tolist() == rows.tolist()


def test_the_layout_of_samples_names_sizes_strides_and_columns():
    message = sample_message(np.zeros((4, 3)), COLUMNS)
    outer, inner = message.layout.dim
    assert (outer.label, outer.size, outer.stride) == ("sample", 4, 12)
    assert (inner.label, inner.size, inner.stride) == ("t[s],u[V],q3[m]", 3, 3)
    assert message.layout.data_offset == 0
    assert isinstance(message.data, array)


@pytest.mark.parametrize("shape", [(3,), (4, 2), (4, 4), (1, 4, 3)])
def test_rows_that_do_not_fit_the_columns_are_refused(shape):
    with pytest.raises(ValueError, match=r"^rows of shape \(.*\): must be \(n, 3\)$"):
        sample_message(np.zeros(shape), COLUMNS)


def test_samples_of_other_columns_are_refused_by_the_reader():
    with pytest.raises(ValueError, match="must be 'gap"):
        read_samples(sample_message(np.zeros((4, 3)), COLUMNS), ("gap[rad]",))
