"""Stamps of messages against the clock of the node that takes them."""

import time

import pytest
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from bdt_msgs_py.clock_agreement import ClockAgreement
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import CLOCK
from bdt_msgs_py.writing import stamp_from_nanoseconds

SECOND = 1_000_000_000


class Bench:
    """A node with a source of the clock."""

    def __init__(self, ros, *, use_sim_time):
        self.ros = ros
        self.node = ros.create(Node, "node", use_sim_time=use_sim_time)
        self.agreement = ClockAgreement(self.node)
        self.publisher = ros.create(Node, "source").create_publisher(
            Clock, CLOCK.name, qos_profile(CLOCK)
        )

    def tick(self, stamp):
        message = Clock(clock=stamp_from_nanoseconds(stamp))

        def arrived():
            self.publisher.publish(message)
            return self.node.get_clock().now().nanoseconds == stamp

        self.ros.spin_until(arrived)

    def faults(self, *stamps):
        for stamp in stamps:
            self.agreement.note(stamp)
        return self.agreement.fault()


@pytest.mark.parametrize("first", [0, 1_795_000_000 * SECOND])
def test_simulated_time_that_nobody_publishes_is_told_when_messages_go_on_for_a_second(ros, first):
    bench = Bench(ros, use_sim_time=True)
    assert bench.faults(first, first + SECOND // 2) == ""
    assert bench.faults(first + SECOND) == (
        "use_sim_time is true and nobody publishes /clock: set it to false where there is none"
    )


def test_messages_of_wall_time_do_not_go_with_a_simulated_clock(ros):
    bench = Bench(ros, use_sim_time=True)
    bench.tick(5 * SECOND)
    assert bench.faults(4 * SECOND, 6 * SECOND) == ""
    assert bench.faults(1_795_000_000 * SECOND) == (
        "use_sim_time is true and messages are stamped 1795000000 s while /clock says 5 s: "
        "set it to false where stamps are wall time"
    )
    assert bench.faults(7 * SECOND) == ""


def test_what_was_said_holds_while_nothing_comes(ros):
    bench = Bench(ros, use_sim_time=True)
    text = bench.faults(0, 2 * SECOND)
    assert text
    assert bench.faults() == text
    bench.tick(2 * SECOND)
    assert bench.faults(3 * SECOND) == ""


def test_a_run_that_begins_anew_is_no_fault(ros):
    bench = Bench(ros, use_sim_time=True)
    assert bench.faults(100 * SECOND, 0) == ""


def test_with_wall_time_there_is_nothing_to_tell(ros):
    bench = Bench(ros, use_sim_time=False)
    assert bench.faults(0, 10 * SECOND) == ""
    assert bench.faults(time.time_ns()) == ""
