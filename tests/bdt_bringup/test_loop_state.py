"""The state of a loop in one word, from what its nodes say."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_bringup.loop_state import (
    DEGRADED,
    MACHINES,
    NODES,
    OK,
    SILENCE,
    STOPPED,
    LoopState,
    NodeReport,
    loop_state,
)

NOW = 100.0


def said(level=0, text="well", state="", age=0.5):
    return NodeReport(level, text, state, NOW - age)


def healthy(**others):
    nodes = {name: said() for name in ("plant", "controller", "twin", "recorder")}
    return nodes | others


def test_a_loop_whose_nodes_are_well_is_ok():
    assert loop_state(healthy(), NOW) == LoopState(OK, "", "4 nodes are well")


def test_nobody_who_says_anything_is_no_loop():
    assert loop_state({}, NOW) == LoopState(STOPPED, "", "no node has said anything")


def test_a_loop_without_a_twin_is_ok_and_says_so():
    state = loop_state({"driver": said(state="armed"), "controller": said()}, NOW)
    assert state == LoopState(OK, "", "machine and controller are well, there is no twin")


@pytest.mark.parametrize("name", ["plant", "controller", "twin", "recorder"])
def test_a_warning_degrades_the_loop_and_is_its_reason(name):
    state = loop_state(healthy(**{name: said(1, "measurements missing")}), NOW)
    assert state == LoopState(DEGRADED, name, "measurements missing")


@pytest.mark.parametrize(
    ("name", "word"),
    [("plant", STOPPED), ("controller", STOPPED), ("twin", DEGRADED), ("recorder", DEGRADED)],
)
def test_silence_stops_a_loop_that_cannot_do_without_the_node(name, word):
    state = loop_state(healthy(**{name: said(age=SILENCE + 4.0)}), NOW)
    assert state == LoopState(word, name, "has said nothing for 7 s")
    assert loop_state(healthy(**{name: said(age=SILENCE)}), NOW).word == OK


@pytest.mark.parametrize("missing", ["plant", "controller"])
def test_a_loop_is_stopped_before_machine_and_controller_were_heard(missing):
    nodes = healthy()
    del nodes[missing]
    state = loop_state(nodes, NOW)
    assert (state.word, state.node) == (STOPPED, "")


def test_a_machine_in_error_is_stopped_with_its_reason():
    state = loop_state(healthy(plant=said(2, "position beyond its limit")), NOW)
    assert state == LoopState(STOPPED, "plant", "position beyond its limit")


@pytest.mark.parametrize(
    ("state", "word"), [("closed", STOPPED), ("open", STOPPED), ("faulted", STOPPED), ("armed", OK)]
)
def test_a_driver_that_is_not_armed_moves_nothing(state, word):
    nodes = {"driver": said(text=state, state=state), "controller": said(), "twin": said()}
    assert loop_state(nodes, NOW).word == word


def test_a_plant_that_is_gone_is_forgotten_for_the_driver_in_its_place():
    nodes = healthy(plant=said(age=50.0), driver=said(state="armed"))
    assert loop_state(nodes, NOW).word == OK


def test_the_line_has_word_node_and_reason():
    assert str(LoopState(DEGRADED, "twin", "late")) == "degraded: twin: late"
    assert str(LoopState(OK, "", "4 nodes are well")) == "ok: 4 nodes are well"


reports = st.builds(
    said,
    st.integers(0, 3),
    st.just("text"),
    st.sampled_from(["", "armed", "open"]),
    st.floats(0, 9),
)


@given(st.dictionaries(st.sampled_from(NODES), reports))
def test_a_loop_is_ok_exactly_if_nothing_needs_attention(nodes):
    state = loop_state(nodes, NOW)
    assert state.word in (OK, DEGRADED, STOPPED)
    assert state.reason
    if state.word == OK:
        machine = min(NOW - nodes[name].heard for name in MACHINES if name in nodes)
        assert machine <= SILENCE
        rest = [one for name, one in nodes.items() if name not in MACHINES]
        assert all(one.level == 0 and NOW - one.heard <= SILENCE for one in rest)
    elif state.node:
        cause = nodes[state.node]
        assert cause.level or NOW - cause.heard > SILENCE or cause.state not in ("", "armed")
