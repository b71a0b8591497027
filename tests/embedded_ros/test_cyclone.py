"""Samples come out of Cyclone DDS whole, with what is told of them, whatever comes in between."""

import os
import time

import pytest
from cyclonedds.core import Policy, Qos
from embedded_ros.endpoints import Reader, Writer
from embedded_ros.session import Session
from interrupted_calls import end_of_interrupted

from embedded_ros import cyclone

TIMEOUT = 20.0

SESSION = """
import os
from cyclonedds.core import Policy, Qos
from embedded_ros.endpoints import Reader, Writer
from embedded_ros.session import Session
session = Session(int(os.environ["ROS_DOMAIN_ID"]), "/")
qos = Qos(Policy.History.KeepLast(1))
writer = Writer(session.participant, session.publisher, "rt/told", "std_msgs/msg/Int64", qos)
reader = Reader(session.participant, session.subscriber, "rt/told", "std_msgs/msg/Int64", qos)
payload = bytes([0, 1, 0, 0]) + bytes(8)
"""


def test_ctrl_c_while_a_sample_is_taken_is_an_exception_as_anywhere():
    """The binding calls a class of Python for each sample, and crashes where that is broken off."""
    assert end_of_interrupted(SESSION, "(writer.write(payload), reader.take())") == (0, "")


@pytest.fixture
def ends():
    session = Session(int(os.environ["ROS_DOMAIN_ID"]), "/")
    qos = Qos(Policy.History.KeepAll, Policy.Reliability.Reliable(10**9))
    topic = "rt/taken", "std_msgs/msg/Int64", qos
    yield (
        Writer(session.participant, session.publisher, *topic),
        Reader(session.participant, session.subscriber, *topic),
    )
    session.close()


@pytest.mark.parametrize("size", [8, 12, 100_000])
def test_a_sample_is_its_bytes_when_it_was_written_and_by_whom(ends, size):
    writer, reader = ends
    payload = bytes([0, 1, 0, 0]) + os.urandom(size)
    begun = time.time_ns()
    writer.write(payload)
    deadline = time.monotonic() + TIMEOUT
    while (sample := reader.take()) is None:
        assert time.monotonic() < deadline
    taken, info = sample
    assert taken == payload
    assert begun <= info.source_timestamp <= time.time_ns()
    assert info.publication_handle == cyclone.instance_handle(writer.ref)
    assert reader.take() is None


def test_news_of_a_writer_that_went_is_no_sample(ends):
    writer, reader = ends
    deadline = time.monotonic() + TIMEOUT
    while not reader.matched_writers():
        assert time.monotonic() < deadline
    writer.close()
    while reader.matched_writers():
        assert time.monotonic() < deadline
    assert reader.take() is None
    reader.close()
    assert reader.take() is None
