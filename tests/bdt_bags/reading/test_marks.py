"""Moments that somebody has marked, as a bag tells them."""

import numpy as np
import pytest
from recorded_loops import ros, stamp

from bdt_bags.reading.recording import load_recording
from bdt_msgs_py.topics import MARK

TIME = np.arange(0.0, 10.0, 0.01)


@pytest.fixture
def signal(signal_messages):
    return signal_messages(TIME, np.sin(TIME), [(0.0, 1.0)])


def mark(signal, time, **changes):
    header = ros("std_msgs/msg/Header", stamp=stamp(time), frame_id="live")
    for name, value in changes.items():
        setattr(header.stamp, name, value)
    signal.add(MARK, time, header)


def marks(signal, path):
    return load_recording(signal.write(path / "bag")).marks


def test_marks_are_those_of_the_bag_in_the_order_of_time(signal, tmp_path):
    mark(signal, 6.25)
    mark(signal, 2.5)
    assert marks(signal, tmp_path) == (2.5, 6.25)


def test_a_stamp_that_is_no_time_marks_nothing(signal, tmp_path):
    mark(signal, 2.0, sec=-1)
    mark(signal, 3.0, nanosec=2**32 - 1)
    mark(signal, 4.0)
    assert marks(signal, tmp_path) == (4.0,)


def test_a_bag_in_which_nobody_has_marked_anything_has_no_marks(signal, tmp_path):
    assert marks(signal, tmp_path) == ()
