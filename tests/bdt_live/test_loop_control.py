"""What a page asks for, and which node is asked for what, in which order."""

import pytest

from bdt_live.loop_control import STEP, LoopControl
from bdt_live.page_requests import PageRequest

OFFERED = {
    "plant": ("gap.kind", "gap.initial", "pace", "pause_at"),
    "driver": (),
    "controller": ("dead_zone_tolerance", "pid.proportional"),
    "twin": ("reconfigure",),
}


class Nodes:
    """Nodes that note what they are asked for, in the order in which they are asked."""

    def __init__(self, **offered):
        self.asked, self.refusing = [], {}
        self.parameters = {
            node: AskedNode(node, self, names) for node, names in {**OFFERED, **offered}.items()
        }
        self.time = 12.5
        self.control = LoopControl(self.parameters, lambda: self.time, lambda: 0.1)

    def use(self, preset):
        return self.do("preset", preset=preset)

    def do(self, action, **fields):
        answers = []
        self.control.do(PageRequest(1, action, **fields), answers.append)
        (answer,) = answers
        return answer


class AskedNode:
    """One of them."""

    def __init__(self, name, nodes, names):
        self.name, self._nodes, self.reconfigurable = name, nodes, names
        self.values = {}

    def set(self, values, answer):
        self._nodes.asked.append((self.name, values))
        self.values |= values
        answer(self._nodes.refusing.get(self.name))


def test_the_twin_has_the_dead_zone_again_only_after_the_controller_got_that_of_the_figure():
    nodes = Nodes()
    assert nodes.use("paper") is None
    assert [name for name, _ in nodes.asked] == ["twin", "controller", "plant", "twin"]
    first, controller, _, last = (values for _, values in nodes.asked)
    assert first["reconfigure"] is False
    assert controller["dead_zone_tolerance"] == 0.0
    assert last == {"reconfigure": True}


@pytest.mark.parametrize("preset", ["linear", "fixed_dead_zone"])
def test_a_figure_without_a_twin_leaves_the_dead_zone_to_nobody(preset):
    nodes = Nodes()
    nodes.use(preset)
    assert [values for name, values in nodes.asked if name == "twin"] == [{"reconfigure": False}]


def test_a_loop_without_a_twin_is_asked_for_the_rest():
    nodes = Nodes(twin=())
    nodes.use("paper")
    assert [name for name, _ in nodes.asked] == ["controller", "plant"]


def test_the_gap_of_a_figure_begins_now_and_the_pace_stays():
    nodes = Nodes()
    nodes.use("paper")
    plant = dict(nodes.asked)["plant"]
    assert plant["gap.begin_time"] == 12.5
    assert "pace" not in plant


def test_a_node_that_refuses_keeps_the_twin_from_nothing_and_its_reason_is_told():
    nodes = Nodes()
    nodes.refusing = {"controller": "it has hung", "plant": "so has it"}
    assert nodes.use("paper") == "it has hung"
    assert nodes.asked[-1] == ("twin", {"reconfigure": True})


def test_a_loop_that_is_stepped_is_paused_from_the_beginning_of_the_step_to_its_end():
    """Or who presses "go on" right after "step" would ask for another pause."""
    nodes = Nodes()
    nodes.do("pause")
    assert nodes.control.is_paused
    nodes.do("step")
    assert nodes.control.is_paused
    nodes.time += STEP
    assert nodes.control.is_paused
    nodes.do("resume")
    assert not nodes.control.is_paused


def test_a_pause_that_is_far_away_is_none():
    nodes = Nodes()
    nodes.parameters["plant"].values["pause_at"] = nodes.time + 1.0
    assert not nodes.control.is_paused


@pytest.mark.parametrize(("mode", "pace"), [("lockstep", 2.0), ("realtime", None)])
def test_a_plant_in_real_time_has_no_pace_that_could_be_chosen(mode, pace):
    nodes = Nodes()
    nodes.parameters["plant"].values |= {"mode": mode, "pace": 2.0}
    assert nodes.control.pace == pace
