"""The monitor shows what can be true, and no message ends it."""

import math

import pytest
from rcl_interfaces.msg import Parameter, ParameterEvent, ParameterValue
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from bdt_bringup.monitor import MonitorNode
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import BACKLASH_ESTIMATE, CLOCK, PARAMETER_EVENTS
from bdt_msgs_py.writing import gap_estimate, platform_position, stamp_from_nanoseconds


class Bench:
    """A monitor and a node that publishes what it listens to."""

    def __init__(self, ros):
        self.ros = ros
        self.monitor = ros.create(MonitorNode)
        node = ros.create(Node, "bench")
        self.publishers = {
            topic: node.create_publisher(kind, topic.name, qos_profile(topic))
            for topic, kind in (
                (CLOCK, Clock),
                (BACKLASH_ESTIMATE, JointState),
                (PARAMETER_EVENTS, ParameterEvent),
            )
        }
        for publisher in self.publishers.values():
            ros.spin_until(lambda publisher=publisher: publisher.get_subscription_count() >= 1)

    def is_rejected(self, topic, message):
        before = self.monitor.rejected.total
        self.publishers[topic].publish(message)
        self.ros.spin_until(lambda: self.monitor.rejected.total == before + 1)


def dead_zone(value, node="/controller"):
    number = ParameterValue(type=3, double_value=value)
    return ParameterEvent(
        node=node, changed_parameters=[Parameter(name="dead_zone_tolerance", value=number)]
    )


def test_the_gap_is_that_of_the_last_estimate_that_is_one(ros):
    bench = Bench(ros)
    bench.publishers[BACKLASH_ESTIMATE].publish(gap_estimate(0, 0.1, 0.0, 0.0))
    ros.spin_until(lambda: bench.monitor.gap == 0.1)
    for stray in (JointState(), platform_position(0, 1.0), gap_estimate(0, math.nan, 0.0, 0.0)):
        bench.is_rejected(BACKLASH_ESTIMATE, stray)
    assert bench.monitor.gap == 0.1


def test_the_time_is_that_of_the_clock_that_goes_on(ros):
    bench = Bench(ros)
    bench.publishers[CLOCK].publish(Clock(clock=stamp_from_nanoseconds(10**9)))
    ros.spin_until(lambda: bench.monitor.simulated_time == 1.0)
    for stamp in (-1, -(10**9), 10**12, (2**31 - 1) * 10**9):
        bench.is_rejected(CLOCK, Clock(clock=stamp_from_nanoseconds(stamp)))
    assert bench.monitor.simulated_time == 1.0


@pytest.mark.parametrize("value", [math.nan, -1.0, 1e300])
def test_the_dead_zone_is_one_that_a_controller_can_have(ros, value):
    bench = Bench(ros)
    events = bench.publishers[PARAMETER_EVENTS]
    events.publish(dead_zone(1e-4))
    ros.spin_until(lambda: bench.monitor.dead_zone == 1e-4)
    bench.is_rejected(PARAMETER_EVENTS, dead_zone(value))
    events.publish(dead_zone(0.5, node="/somebody"))
    events.publish(dead_zone(2e-4, node="/controller"))
    ros.spin_until(lambda: bench.monitor.dead_zone != 1e-4)
    assert bench.monitor.dead_zone == 2e-4
