"""What discovery tells, and signals that come while it is asked."""

import os
import signal

import pytest
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from embedded_ros.endpoints import _carrier

from embedded_ros import discovery

pytestmark = pytest.mark.usefixtures("signals_as_in_any_program")


@pytest.fixture
def participant():
    return DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))


@pytest.mark.parametrize("with_qos", [False, True])
def test_ctrl_c_in_a_question_is_that_and_costs_no_answer(participant, monkeypatch, with_qos):
    """Cyclone DDS makes an error of its own of what a constructor raises that it calls."""
    writer = DataWriter(participant, Topic(participant, "rt/x", _carrier("std_msgs/msg/Float64")))
    make = discovery._endpoint

    def make_late(*values):
        signal.raise_signal(signal.SIGINT)
        return make(*values)

    known = discovery.Discovery(participant)
    with monkeypatch.context() as patched:
        patched.setattr(discovery, "_endpoint", make_late)
        with pytest.raises(KeyboardInterrupt):
            known.writers(with_qos=with_qos)
    assert "rt/x" in [each.topic for each in known.writers(with_qos=with_qos)]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    del writer
