"""Who set the controller's dead zone last, as far as its parameter events tell."""

import math
import sys

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import ParameterEvent
from rclpy.parameter import Parameter
from telemetry_operator import Operator

from bdt_controller.controller_node import ControllerNode
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import DIAGNOSTICS, PARAMETER_EVENTS
from bdt_twin.dead_zone_in_force import DeadZoneInForce
from bdt_twin.twin_node import TwinNode

BY_HAND = 5e-5


def test_before_the_first_event_nothing_is_known():
    assert DeadZoneInForce() == DeadZoneInForce(tolerance=None, set_by="unknown")


def test_what_the_twin_asked_for_was_set_by_the_twin():
    dead_zone = DeadZoneInForce()
    dead_zone.request(1e-5)
    dead_zone.request(2e-5)
    assert not dead_zone.note(1e-5, is_new=False), "an event may come after the next request"
    assert not dead_zone.note(2e-5, is_new=False)
    assert (dead_zone.tolerance, dead_zone.set_by) == (2e-5, "twin")


def test_any_other_value_was_set_by_somebody_else_and_is_news():
    dead_zone = DeadZoneInForce()
    dead_zone.request(1e-5)
    assert dead_zone.note(3e-5, is_new=False)
    assert (dead_zone.tolerance, dead_zone.set_by) == (3e-5, "somebody else")


def test_a_controller_that_starts_brings_its_own():
    dead_zone = DeadZoneInForce()
    assert not dead_zone.note(0.0, is_new=True)
    assert (dead_zone.tolerance, dead_zone.set_by) == (0.0, "start-up of the controller")


ALWAYS_KNOWS = """
from bdt_twin.estimator import Estimate

class AlwaysKnows:
    def restart(self):
        pass

    def update(self, batch):
        return Estimate(batch[-1, 0], 0.25)
"""


class Loop(Operator):
    """A controller, a twin that has an estimate with every batch, and an operator."""

    def __init__(self, ros):
        super().__init__(ros)
        self.said = {}
        self.node.create_subscription(
            DiagnosticArray, DIAGNOSTICS.name, self._hear, qos_profile(DIAGNOSTICS)
        )
        self.twin = ros.create(
            TwinNode, estimator__kind="always_knows:AlwaysKnows", communication_delay=0.0
        )
        ros.spin_until(lambda: self.telemetry.get_subscription_count() == 1)
        ros.spin_until(lambda: self.node.count_subscribers("/parameter_events") >= 1)
        self.controller = ros.create(ControllerNode)

    def _hear(self, message):
        (status,) = message.status
        self.said[status.name] = {each.key: each.value for each in status.values}

    @property
    def in_force(self):
        return self.controller.get_parameter("dead_zone_tolerance").value

    def wait_for(self, author):
        self.ros.spin_until(lambda: self.health["dead_zone_set_by"] == author)
        assert self.health["dead_zone_in_force_m"] == self.in_force


@pytest.fixture
def loop(ros, tmp_path, monkeypatch):
    (tmp_path / "always_knows.py").write_text(ALWAYS_KNOWS)
    monkeypatch.chdir(tmp_path)
    yield Loop(ros)
    sys.modules.pop("always_knows")


def test_the_twin_says_who_set_the_dead_zone_and_sets_it_again(ros, loop):
    loop.wait_for("start-up of the controller")
    loop.estimate()
    loop.wait_for("twin")
    by_twin = loop.in_force
    loop.set("controller", "dead_zone_tolerance", BY_HAND)
    loop.wait_for("somebody else")
    assert loop.in_force == BY_HAND
    loop.estimate()
    loop.wait_for("twin")
    assert loop.in_force == by_twin


def test_the_dead_zone_can_be_taken_over_and_given_back(ros, loop):
    loop.wait_for("start-up of the controller")
    loop.set("twin", "reconfigure", False)
    loop.set("controller", "dead_zone_tolerance", BY_HAND)
    for _ in range(3):
        loop.estimate()
    ros.spin_for(0.2)
    assert loop.in_force == BY_HAND
    loop.wait_for("somebody else")
    assert loop.health["reconfigure"] is False
    loop.set("twin", "reconfigure", True)
    loop.estimate()
    loop.wait_for("twin")
    # From a dead zone that it finds, the twin goes on at a limited rate.
    ros.spin_until(lambda: loop.in_force != BY_HAND or loop.estimate())
    loop.wait_for("twin")


@pytest.mark.parametrize("value", [math.nan, -1e-5, 1e300])
def test_a_dead_zone_that_cannot_be_is_not_believed(ros, loop, value):
    loop.wait_for("start-up of the controller")
    events = loop.node.create_publisher(
        ParameterEvent, PARAMETER_EVENTS.name, qos_profile(PARAMETER_EVENTS)
    )
    ros.spin_until(lambda: events.get_subscription_count() == 1)
    changed = Parameter("dead_zone_tolerance", value=value).to_parameter_msg()
    events.publish(ParameterEvent(node="/controller", changed_parameters=[changed]))
    ros.spin_until(lambda: loop.health["rejected_messages"] == 1)
    loop.wait_for("start-up of the controller")


def test_the_controller_says_whether_its_dead_zone_is_the_one_it_began_with(ros, loop):
    ros.spin_until(lambda: "/controller" in loop.said)
    assert loop.said["/controller"]["dead_zone_set_by"] == "start-up"
    loop.set("controller", "pid.integral", 25000.0)
    loop.said.clear()
    ros.spin_until(lambda: "/controller" in loop.said)
    assert loop.said["/controller"]["dead_zone_set_by"] == "start-up"
    loop.set("controller", "dead_zone_tolerance", BY_HAND)
    loop.said.clear()
    ros.spin_until(lambda: "/controller" in loop.said)
    assert loop.said["/controller"]["dead_zone_set_by"] == "parameter service"
