"""Requests to the controller's parameter service, and which controller is a new one."""

from functools import partial

import pytest
from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node

from bdt_msgs_py.topics import CONTROLLER_NODE, PARAMETER_EVENTS
from bdt_twin.dead_zone_requests import DeadZoneRequests
from bdt_twin.link import Reconfiguration

WIDE = Reconfiguration(due=0, estimated=0, tolerance=3e-5)
WITH_OFFSET = WIDE._replace(voltage_offset=-0.02)


class Asker:
    """A node that asks for dead zones."""

    def __init__(self, ros, timeout=20.0):
        self.ros, self.ended, self.unanswered = ros, 0, []
        self.node = ros.create(Node, "asker")
        self.requests = DeadZoneRequests(self.node, CONTROLLER_NODE, timeout, self._end)

    def _end(self, unanswered):
        self.ended += 1
        self.unanswered.append(unanswered)

    def start_controller(self, *others):
        """Start a controller and wait until it can be told from others."""
        known = self.node.count_publishers(PARAMETER_EVENTS.name)
        controller = self.ros.create(Node, CONTROLLER_NODE)
        for name in ("dead_zone_tolerance", *others):
            controller.declare_parameter(name, 0.0)
        self.ros.spin_until(lambda: self.node.count_publishers(PARAMETER_EVENTS.name) > known)
        return controller

    def ask(self, wanted=WIDE):
        self.requests.send(wanted)
        self.ros.spin_until(lambda: self.ended)


def in_force(controller):
    return controller.get_parameter("dead_zone_tolerance").value


def test_a_controller_is_new_once(ros):
    asker = Asker(ros)
    assert not asker.requests.controller_appeared()
    asker.start_controller()
    assert asker.requests.controller_appeared()
    assert not asker.requests.controller_appeared()


def test_a_controller_that_has_answered_is_not_new(ros):
    asker = Asker(ros)
    controller = asker.start_controller()
    asker.ask()
    assert (asker.requests.accepted, in_force(controller)) == (1, WIDE.tolerance)
    assert not asker.requests.controller_appeared()
    asker.start_controller()
    assert asker.requests.controller_appeared()


def test_a_controller_that_comes_before_the_answer_of_another_one_is_new(ros):
    asker = Asker(ros)
    asker.start_controller()
    assert asker.requests.controller_appeared()
    asker.requests.send(WIDE)
    # Without services, so that it is the other one that answers.
    ros.create(partial(Node, start_parameter_services=False), CONTROLLER_NODE)
    ros.spin_until(lambda: asker.ended)
    assert asker.requests.accepted == 1
    assert asker.requests.controller_appeared()


def test_a_controller_that_answers_before_it_is_seen_is_not_new(ros, monkeypatch):
    asker = Asker(ros)
    asker.start_controller()
    with monkeypatch.context() as unseen:
        unseen.setattr(asker.node, "get_publishers_info_by_topic", lambda _: [])
        asker.ask()
        assert (asker.requests.accepted, asker.requests.informed) == (1, ())
    assert not asker.requests.controller_appeared()
    assert len(asker.requests.informed) == 1
    asker.start_controller()
    assert asker.requests.controller_appeared()


def test_a_controller_that_is_noted_before_it_is_seen_is_not_new(ros):
    asker = Asker(ros)
    asker.requests.note_informed()
    asker.start_controller()
    assert not asker.requests.controller_appeared()
    asker.start_controller()
    assert asker.requests.controller_appeared()


def test_it_is_told_which_lives_of_the_controller_have_what_was_asked_for(ros):
    asker = Asker(ros)
    asker.start_controller()
    asker.requests.controller_appeared()
    assert asker.requests.informed == ()
    asker.ask()
    (life,) = asker.requests.informed
    later = Asker(ros)
    later.requests.note_informed([life])
    ros.spin_until(later.requests._found_publishers)
    assert not later.requests.controller_appeared()
    later.start_controller()
    assert later.requests.controller_appeared()
    assert later.requests.informed == (life,)


def test_a_request_waits_for_the_service(ros):
    asker = Asker(ros)
    asker.requests.send(WIDE)
    controller = asker.start_controller()
    ros.spin_until(lambda: asker.ended)
    assert (asker.requests.accepted, in_force(controller)) == (1, WIDE.tolerance)


def test_a_request_that_waits_can_be_dropped(ros):
    asker = Asker(ros)
    asker.requests.send(WIDE)
    asker.requests.drop()
    assert asker.requests.in_flight is None
    controller = asker.start_controller()
    ros.spin_for(0.3)
    assert in_force(controller) == 0.0
    assert (asker.requests.accepted, asker.requests.failed) == (0, 0)


def test_an_answer_that_comes_when_the_node_goes_is_not_taken(ros):
    asker = Asker(ros)
    controller = asker.start_controller()
    asker.requests.send(WIDE)
    ros.spin_until(lambda: asker.requests._answer is not None)
    asker.requests.close()
    ros.spin_until(lambda: in_force(controller) == WIDE.tolerance)
    ros.spin_for(0.1)
    assert (asker.ended, asker.requests.accepted, asker.requests.in_flight) == (0, 0, None)


def test_a_request_that_was_sent_gets_its_answer(ros):
    asker = Asker(ros)
    controller = asker.start_controller()
    asker.ask()
    asker.ended = 0
    asker.requests.send(WIDE._replace(tolerance=4e-5))
    asker.requests.drop()
    assert asker.requests.in_flight is not None
    ros.spin_until(lambda: asker.ended)
    assert (asker.requests.accepted, in_force(controller)) == (2, 4e-5)


def test_what_had_no_answer_is_given_back_once_unless_it_was_dropped(ros):
    asker = Asker(ros, timeout=0.05)
    asker.ask()
    assert asker.unanswered == [WIDE]
    controller = asker.start_controller()
    ros.executor.remove_node(controller)
    asker.requests.send(WIDE)
    ros.spin_until(lambda: asker.requests._answer is not None or asker.ended == 2)
    asker.requests.drop()
    ros.spin_until(lambda: asker.ended == 2)
    assert asker.requests.failed == 2


def test_dead_zone_and_voltage_offset_are_one_request(ros):
    asker = Asker(ros)
    controller = asker.start_controller("voltage_offset")
    calls = []
    controller.add_on_set_parameters_callback(
        lambda changes: calls.append(changes) or SetParametersResult(successful=True)
    )
    asker.ask(WITH_OFFSET)
    asked = [[(change.name, change.value) for change in call] for call in calls]
    assert asked == [[("dead_zone_tolerance", 3e-5), ("voltage_offset", -0.02)]]
    assert (asker.requests.accepted, asker.requests.refused_offsets) == (1, 0)


def test_a_controller_without_a_voltage_offset_gets_its_dead_zone_all_the_same(ros):
    asker = Asker(ros)
    controller = asker.start_controller()
    asker.ask(WITH_OFFSET)
    assert in_force(controller) == WIDE.tolerance
    assert not controller.has_parameter("voltage_offset")
    requests = asker.requests
    assert (requests.accepted, requests.failed, requests.refused_offsets) == (1, 0, 1)
    assert asker.unanswered == [None]


def test_a_controller_that_refuses_the_dead_zone_as_well_is_one_failure(ros):
    asker = Asker(ros)
    controller = asker.start_controller("voltage_offset")
    controller.add_on_set_parameters_callback(
        lambda _: SetParametersResult(successful=False, reason="busy")
    )
    asker.ask(WITH_OFFSET)
    assert (asker.requests.accepted, asker.requests.failed) == (0, 1)
    assert in_force(controller) == 0.0


def test_a_voltage_offset_that_waits_for_the_service_can_be_forgotten(ros):
    asker = Asker(ros)
    asker.requests.send(WITH_OFFSET)
    asker.requests.forget_offset()
    controller = asker.start_controller("voltage_offset")
    ros.spin_until(lambda: asker.ended)
    assert in_force(controller) == WIDE.tolerance
    assert controller.get_parameter("voltage_offset").value == 0.0


@pytest.mark.parametrize("name", ["/left/controller", "controller"])
def test_a_controller_in_another_namespace_is_another_one(ros, name):
    left = ros.create(lambda **options: Node("asker", namespace="/left", **options))
    requests = DeadZoneRequests(left, name, 20.0, lambda _: None)
    Asker(ros).start_controller()
    ros.spin_until(lambda: left.count_publishers(PARAMETER_EVENTS.name) == 3)
    assert not requests.controller_appeared()
    controller = ros.create(lambda **options: Node("controller", namespace="/left", **options))
    ros.spin_until(requests.controller_appeared)
    assert controller.get_fully_qualified_name() == "/left/controller"


GAINS = (("pid.proportional", 6000.0), ("notch.frequency", 27.0))


def test_gains_are_set_with_the_dead_zone_in_one_call(ros):
    asker = Asker(ros)
    controller = asker.start_controller(*dict(GAINS), "voltage_offset")
    asker.ask(WITH_OFFSET._replace(gains=GAINS))
    assert (asker.requests.accepted, in_force(controller)) == (1, WIDE.tolerance)
    assert {name: controller.get_parameter(name).value for name, _ in GAINS} == dict(GAINS)
    assert controller.get_parameter("voltage_offset").value == -0.02


def test_a_controller_without_these_gains_gets_the_dead_zone_alone(ros):
    asker = Asker(ros)
    controller = asker.start_controller()
    asker.ask(WIDE._replace(gains=GAINS))
    assert (asker.requests.accepted, in_force(controller)) == (1, WIDE.tolerance)
    assert asker.requests.refused_offsets == 1
