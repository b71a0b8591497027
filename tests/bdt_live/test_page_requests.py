"""What a page may ask for, and everything else that could be sent."""

import contextlib
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_live.page_requests import (
    LARGEST_MESSAGE,
    WITHOUT_FIELDS,
    PageRequest,
    PageRequestError,
    read_request,
)


def request(**fields):
    return json.dumps({"number": 1, **fields})


@pytest.mark.parametrize("action", WITHOUT_FIELDS)
def test_actions_without_fields(action):
    assert read_request(request(action=action)) == PageRequest(1, action)


def test_parameters_are_set_by_node_and_name():
    text = request(action="set", node="plant", values={"gap.kind": "constant", "gap.initial": 0.1})
    assert read_request(text) == PageRequest(
        1, "set", "plant", (("gap.kind", "constant"), ("gap.initial", 0.1))
    )


def test_a_pace_and_a_preset():
    assert read_request(request(action="pace", amount=2)).amount == 2.0
    assert read_request(request(action="preset", preset="paper")).preset == "paper"


@pytest.mark.parametrize(
    "text",
    [
        "",
        "null",
        "[]",
        "{",
        "[" * 3000,
        '{"number": 1}',
        '{"number": true, "action": "pause"}',
        '{"number": 1.0, "action": "pause"}',
        '{"number": -1, "action": "pause"}',
        request(action=["pause"]),
        request(action={}),
        request(action="quit"),
        request(action="save", name="../../etc/passwd"),
        request(action="set"),
        request(action="set", node="recorder", values={"a": 1}),
        request(action="set", node=["plant"], values={"a": 1}),
        request(action="set", node="plant", values={}),
        request(action="set", node="plant", values={"a b": 1}),
        request(action="set", node="plant", values={"$(id)": 1}),
        request(action="set", node="plant", values={"a": [1]}),
        request(action="set", node="plant", values={"a": None}),
        request(action="set", node="plant", values={"a": 2**63}),
        request(action="set", node="plant", values={"a": "line\nline"}),
        request(action="set", node="plant", values={"a": "x" * 201}),
        request(action="set", node="plant", values={f"a{n}": 1 for n in range(9)}),
        request(action="pace", amount=0.0),
        request(action="pace", amount=1e9),
        request(action="pace", amount=float("nan")),
        request(action="pace", amount="1"),
        request(action="preset", preset="../paper"),
        request(action="preset", preset=["paper"]),
        '{"number": 1, "action": "set", "node": "plant", "values": {"a": 1e999}}',
        "x" * (LARGEST_MESSAGE + 1),
    ],
    ids=range(33),
)
def test_everything_else_is_refused(text):
    with pytest.raises(PageRequestError):
        read_request(text)


anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3)
    ),
    max_leaves=10,
)
fields = st.fixed_dictionaries(
    {"number": anything, "action": anything | st.sampled_from(["set", "pace", "preset"])},
    optional={"node": anything, "values": anything, "amount": anything, "preset": anything},
)


@given(fields | anything)
def test_nothing_but_a_refusal_comes_of_a_hostile_message(message):
    with contextlib.suppress(PageRequestError):
        assert isinstance(read_request(json.dumps(message)), PageRequest)
