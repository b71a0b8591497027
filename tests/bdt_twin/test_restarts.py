"""Twin and controller that are started anew: what was in force is in force again, and at once."""

import json
import sys
import time

import numpy as np
import pytest
from telemetry_operator import Operator

from bdt_controller.controller_node import ControllerNode
from bdt_msgs_py.diagnostics import PERIOD
from bdt_msgs_py.node_parameters import ConfigurationError
from bdt_twin.twin_node import TwinNode

BY_HAND = 5e-5
IN_FORCE = 1e-3 / (2 * np.pi) * 0.25

KNOWS_ALL = """
from bdt_twin.estimator import Estimate

class KnowsAll:
    def restart(self):
        pass

    def update(self, batch):
        return Estimate(
            batch[-1, 0],
            0.25,
            0.01,
            growth=1e-3,
            voltage_offset=0.02,
            voltage_offset_uncertainty=0.001,
        )
"""


class Loop(Operator):
    """An operator with a controller and a twin that he starts and ends."""

    controller = None

    def start_twin(self, **parameters):
        chosen = {"estimator__kind": "knows_all:KnowsAll", "communication_delay": 0.0}
        self.twin = self.ros.create(TwinNode, **(chosen | parameters))
        self.ros.spin_until(lambda: self.telemetry.get_subscription_count() == 1)

    def start_controller(self, **parameters):
        self.controller = self.ros.create(ControllerNode, **parameters)

    def end(self, *nodes):
        for node in nodes:
            self.ros.executor.remove_node(node)
            node.destroy_node()
        self.ros.spin_until(
            lambda: not self.telemetry.get_subscription_count() or self.twin not in nodes
        )

    def estimate_and_set(self):
        """Have the twin set the dead zone by an estimate."""
        before = self.health["reconfigurations"]
        self.estimate()
        self.ros.spin_until(lambda: self.health["reconfigurations"] > before)

    def has(self, name):
        return self.controller.get_parameter(name).value

    @property
    def dead_zone(self):
        return self.has("dead_zone_tolerance")

    def wait_for_the_twin_s(self):
        """Wait until the controller has what the twin has once estimated."""
        self.ros.spin_until(lambda: self.dead_zone == pytest.approx(IN_FORCE, rel=0.01))
        assert self.has("voltage_offset") == -0.02


@pytest.fixture
def loop(ros, tmp_path, monkeypatch):
    (tmp_path / "knows_all.py").write_text(KNOWS_ALL)
    monkeypatch.chdir(tmp_path)
    yield Loop(ros)
    sys.modules.pop("knows_all", None)


def test_a_new_controller_is_asked_at_once_though_the_dead_one_still_owes_an_answer(ros, loop):
    loop.start_controller()
    loop.start_twin(service_timeout=1000.0)
    ros.spin_until(loop.twin._delivery.requests._client.services_are_ready)
    ros.executor.remove_node(loop.controller)
    loop.estimate()
    ros.spin_until(lambda: loop.twin._delivery.requests._answer is not None)
    loop.controller.destroy_node()
    loop.start_controller()
    loop.wait_for_the_twin_s()


def test_a_controller_that_lost_its_dead_zone_unseen_gets_it_again(ros, loop):
    """Its own diagnostics tell, without an estimate, whatever the graph has told."""
    loop.start_controller()
    loop.start_twin()
    loop.estimate_and_set()
    loop.end(loop.controller)
    loop.start_controller()
    requests = loop.twin._delivery.requests
    known = len(requests._publishers)
    ros.spin_until(lambda: requests.note_informed() or len(requests._publishers) > known)
    assert loop.dead_zone == 0.0
    loop.wait_for_the_twin_s()


def test_what_somebody_else_sets_stays_until_the_next_estimate(ros, loop):
    loop.start_controller()
    loop.start_twin()
    loop.estimate_and_set()
    loop.set("controller", "dead_zone_tolerance", BY_HAND)
    loop.set("controller", "voltage_offset", 0.5)
    # Longer than it takes to hear of it in the diagnostics.
    ros.spin_for(2.5 * PERIOD)
    assert (loop.dead_zone, loop.has("voltage_offset")) == (BY_HAND, 0.5)
    loop.estimate_and_set()
    loop.wait_for_the_twin_s()


def test_a_twin_that_comes_anew_leaves_the_dead_zone_in_force_and_passes_it_on(ros, loop):
    loop.start_controller()
    loop.start_twin()
    loop.estimate_and_set()
    loop.end(loop.twin)
    loop.start_twin()
    ros.spin_until(lambda: loop.health["dead_zone_set_by"] == "before the twin came")
    assert loop.health["dead_zone_in_force_m"] == loop.dead_zone == pytest.approx(IN_FORCE, 0.01)
    assert loop.health["reconfigurations"] == 0
    loop.end(loop.controller)
    loop.start_controller()
    loop.wait_for_the_twin_s()


def test_a_twin_that_comes_anew_passes_on_what_was_set_by_hand_in_the_meantime(ros, loop):
    loop.start_controller()
    loop.start_twin(state_file="twin.json")
    loop.estimate_and_set()
    loop.end(loop.twin)
    loop.set("controller", "dead_zone_tolerance", BY_HAND)
    loop.start_twin(state_file="twin.json")
    ros.spin_until(lambda: loop.health["dead_zone_set_by"] == "before the twin came")
    assert loop.dead_zone == BY_HAND
    loop.end(loop.controller)
    loop.start_controller()
    ros.spin_until(lambda: loop.dead_zone == BY_HAND)


def test_what_a_controller_begins_with_is_not_passed_on_to_the_next_one(ros, loop):
    loop.start_controller(dead_zone_tolerance=BY_HAND)
    loop.start_twin()
    ros.spin_for(2.5 * PERIOD)
    loop.end(loop.controller)
    loop.start_controller(dead_zone_tolerance=7e-5)
    ros.spin_for(2.5 * PERIOD)
    assert loop.dead_zone == 7e-5
    assert loop.health["reconfigurations"] == 0


def test_what_is_in_force_survives_a_restart_of_everything(ros, loop):
    loop.start_controller()
    loop.start_twin(state_file="twin.json")
    loop.estimate_and_set()
    loop.end(loop.twin, loop.controller)
    loop.start_controller()
    loop.start_twin(state_file="twin.json")
    loop.wait_for_the_twin_s()
    health = loop.health
    assert health["estimates"] == 0, "nothing was learned since"
    assert health["recalled_gap_rad"] == 0.25
    assert health["recalled_gap_uncertainty_rad"] >= 0.01
    assert 0.0 < health["recalled_age_s"] < 60.0


def test_without_telemetry_the_state_is_kept_for_the_twin_after_the_next(ros, loop):
    loop.start_controller()
    loop.start_twin(state_file="twin.json")
    loop.estimate_and_set()
    for _ in range(2):
        loop.end(loop.twin, loop.controller)
        loop.start_controller()
        loop.start_twin(state_file="twin.json")
        loop.wait_for_the_twin_s()
        ros.spin_until(lambda: loop.health["reconfigurations"] == 1)
    assert loop.health["recalled_gap_rad"] == 0.25


def test_what_was_answered_is_kept_even_if_the_next_question_is_asked_at_once(ros, loop):
    loop.start_controller()
    loop.start_twin(state_file="twin.json")
    delivery = loop.twin._delivery
    loop.estimate()
    ros.spin_until(lambda: delivery.requests.in_flight is not None)
    delivery._send_again("somebody has doubts")
    ros.spin_until(lambda: delivery.requests.accepted == 1)
    assert delivery.requests.in_flight is not None
    loop.end(loop.twin, loop.controller)
    loop.start_controller()
    loop.start_twin(state_file="twin.json")
    loop.wait_for_the_twin_s()


def test_what_was_kept_takes_the_link_s_delay(ros, loop):
    loop.start_controller()
    loop.start_twin(state_file="twin.json")
    loop.estimate_and_set()
    loop.end(loop.twin, loop.controller)
    loop.start_controller()
    begin = time.monotonic()
    loop.start_twin(state_file="twin.json", communication_delay=0.7)
    loop.wait_for_the_twin_s()
    assert time.monotonic() - begin >= 0.7


def test_a_twin_that_only_estimates_sends_nothing_that_was_kept(ros, loop):
    loop.start_controller()
    loop.start_twin(state_file="twin.json")
    loop.estimate_and_set()
    loop.end(loop.twin, loop.controller)
    loop.start_controller()
    loop.start_twin(state_file="twin.json", reconfigure=False)
    ros.spin_for(2.5 * PERIOD)
    assert (loop.dead_zone, loop.has("voltage_offset")) == (0.0, 0.0)


def test_an_offset_that_somebody_has_taken_over_is_not_sent_from_what_was_kept(ros, loop):
    loop.start_controller()
    loop.start_twin(state_file="twin.json")
    loop.estimate_and_set()
    loop.end(loop.twin, loop.controller)
    loop.start_controller()
    loop.start_twin(state_file="twin.json", compensate_offset=False)
    ros.spin_until(lambda: loop.dead_zone == pytest.approx(IN_FORCE, rel=0.01))
    assert loop.has("voltage_offset") == 0.0


@pytest.mark.parametrize(
    ("content", "is_left_alone"),
    [("", False), ('{"format": "state of a digital tw', False), ("gap: 0.25\n", True)],
)
def test_a_file_of_no_use_is_ignored_and_overwritten_unless_it_is_somebody_else_s(
    ros, loop, tmp_path, content, is_left_alone
):
    path = tmp_path / "twin.json"
    path.write_text(content)
    loop.start_controller()
    loop.start_twin(state_file=str(path))
    assert "recalled_age_s" not in loop.health
    assert bool(loop.health["state_file_error"]) == is_left_alone
    loop.estimate_and_set()
    loop.end(loop.twin)
    if is_left_alone:
        assert path.read_text() == content
    else:
        kept = json.loads(path.read_text())["state"]
        assert kept["in_force"]["dead_zone_tolerance"] == loop.dead_zone


def test_a_state_that_is_too_old_is_ignored(ros, loop):
    loop.start_controller()
    loop.start_twin(state_file="twin.json")
    loop.estimate_and_set()
    loop.end(loop.twin, loop.controller)
    ros.spin_for(0.2)
    loop.start_controller()
    loop.start_twin(state_file="twin.json", state_longest_age=0.1)
    ros.spin_for(2.5 * PERIOD)
    assert loop.dead_zone == 0.0


def test_a_disk_that_refuses_is_a_warning_and_the_twin_goes_on(ros, loop, tmp_path):
    folder = tmp_path / "memory"
    folder.mkdir()
    loop.start_controller()
    loop.start_twin(state_file="memory/twin.json")
    folder.rmdir()
    loop.estimate_and_set()
    loop.wait_for_the_twin_s()
    ros.spin_until(lambda: loop.health["state_file_error"])
    assert "the twin's state is not kept: " in loop.twin._health().summary


@pytest.mark.parametrize("name", ["nowhere/twin.json", "."])
def test_a_state_file_that_cannot_be_is_refused_at_the_start(ros, loop, name):
    with pytest.raises(ConfigurationError) as caught:
        ros.create(TwinNode, state_file=name)
    assert str(caught.value) == (
        f"parameter state_file = {name!r}: must be a file in a folder that exists"
    )


def test_without_a_state_file_nothing_is_written_and_nothing_more_is_said(ros, loop, tmp_path):
    loop.start_controller()
    loop.start_twin()
    loop.estimate_and_set()
    loop.end(loop.twin)
    assert [path.name for path in tmp_path.glob("*") if path.suffix != ".py"] in (
        [],
        ["__pycache__"],
    )
