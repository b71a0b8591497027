"""The parameters of a node without a node, without rclpy and without DDS."""

import subprocess
import sys
import threading

import pytest
from embedded_ros.errors import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from embedded_ros.message_classes import message_class
from embedded_ros.parameter_declaration import read_declarations
from embedded_ros.parameter_store import ParameterStore
from embedded_ros.parameter_table import Entry, ParameterTable
from embedded_ros.parameter_type import ParameterType
from embedded_ros.parameter_value import Parameter
from hypothesis import given
from hypothesis import strategies as st

NAMES = st.sampled_from(["a", "b", "b.x", "c"])
VALUES = st.one_of(st.none(), st.booleans(), st.integers(-5, 5), st.floats(), st.text(max_size=3))


def descriptor(**fields):
    return message_class("rcl_interfaces/msg/ParameterDescriptor")(**fields)


def declare(store, *entries):
    return store.declare(read_declarations("", entries))


def content(store):
    return {name: store.parameter_with_value(name) for name in store}


@pytest.fixture
def told():
    return []


@pytest.fixture
def store(told):
    store = ParameterStore(announce=told.append)
    declare(store, ("a", 1), ("b", 2.0), ("c", None, descriptor(dynamic_typing=True)))
    told.clear()
    return store


def test_it_needs_no_rclpy_and_no_dds():
    program = """
import sys
import embedded_ros.parameter_services
print([name for name in ("rclpy", "cyclonedds", "rcl_interfaces") if name in sys.modules])
"""
    done = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True, timeout=60
    )
    assert done.stdout == "[]\n"


def test_a_change_is_told_once_with_what_it_did(store, told):
    new, changed = Parameter("c", value="x"), Parameter("a", value=5)
    assert store.set([changed, new]) is None
    (changes,) = told
    assert (changes.new, changes.changed, changes.deleted) == ([new], [changed], [])
    gone = Parameter("c")
    assert store.set([gone]) is None
    assert told[1].deleted == [gone]
    assert "c" not in store


def test_what_cannot_be_announced_is_taken_back(store):
    def fail(_):
        raise OverflowError("does not fit into the message")

    store.announce = fail
    before = content(store)
    with pytest.raises(OverflowError):
        store.set([Parameter("a", value=2**70), Parameter("c", value=1)])
    with pytest.raises(OverflowError):
        declare(store, ("d", 2**70))
    assert content(store) == before
    assert store.descriptor("c").type == ParameterType.NOT_SET.value


def test_a_reader_in_another_thread_sees_all_of_a_change_or_nothing(store):
    declare(store, *((f"many.{index}", 0) for index in range(50)))
    torn, done = [], threading.Event()

    def read():
        while not done.is_set():
            values = {parameter.value for parameter in store.below("many").values()}
            if len(values) != 1:
                torn.append(values)

    reader = threading.Thread(target=read)
    reader.start()
    for value in range(200):
        store.set([Parameter(f"many.{index}", value=value) for index in range(50)])
    done.set()
    reader.join(20)
    assert not torn


def test_a_callback_may_remove_itself(store):
    calls = []

    def once(parameters):
        calls.append(parameters)
        store.after_set.remove(once)

    store.after_set.add(once)
    store.set([Parameter("a", value=2)])
    store.set([Parameter("a", value=3)])
    assert len(calls) == 1


def test_overrides_take_the_place_of_defaults():
    store = ParameterStore(overrides={"a": Parameter("a", value=2), "b": Parameter("b", value=1)})
    assert [parameter.value for parameter in declare(store, ("a", 1))] == [2]
    with pytest.raises(InvalidParameterTypeException, match="expecting type 'DOUBLE'"):
        declare(store, ("b", 1.0))
    assert "b" not in store


def test_errors_name_what_is_wrong(store):
    with pytest.raises(ParameterAlreadyDeclaredException, match=r"\['a', 'b'\]"):
        declare(store, ("d", 1), ("a", 1), ("b", 2))
    assert "d" not in store
    declare(store, ("later", ParameterType.DOUBLE), ("fixed", 1, descriptor(read_only=True)))
    with pytest.raises(ParameterUninitializedException, match="'later' is not initialized"):
        store.parameter("later")
    with pytest.raises(ParameterImmutableException, match="fixed"):
        store.undeclare("fixed")
    for ask in (store.parameter, store.type_of, store.descriptor, store.undeclare):
        with pytest.raises(ParameterNotDeclaredException, match="nothing"):
            ask("nothing")
    with pytest.raises(InvalidParameterValueException, match="Wrong parameter type"):
        store.redescribe("a", descriptor(type=ParameterType.STRING.value))


@given(st.lists(st.lists(st.tuples(NAMES, VALUES), max_size=3), max_size=8))
def test_every_set_does_all_or_nothing_and_says_which(changes):
    told = []
    store = ParameterStore(announce=told.append)
    declare(store, ("a", 1), ("b", 2.0), ("c", None, descriptor(dynamic_typing=True)))
    store.declare(read_declarations("b", [("x", "text", descriptor(read_only=True))]))
    for wanted in changes:
        before, count = content(store), len(told)
        parameters = [Parameter(name, value=value) for name, value in wanted]
        try:
            refused = store.set(parameters) is not None
        except ParameterNotDeclaredException:
            refused = True
        if refused:
            assert content(store) == before
            assert len(told) == count
            continue
        expected = dict(before)
        for parameter in parameters:
            expected[parameter.name] = parameter
        gone = {name for name in expected if expected[name] and expected[name].value is None}
        assert content(store) == {n: p for n, p in expected.items() if n not in gone}
        assert len(told) == count + 1


@given(st.lists(st.tuples(NAMES, st.integers()), max_size=4))
def test_a_change_can_be_taken_back(wanted):
    table = ParameterTable()
    table.declare(Entry(Parameter("a", value=1), descriptor()))
    table.declare(Entry(Parameter("b.x"), descriptor(dynamic_typing=True)))
    before = dict(table.items())
    table.take_back(table.set([Parameter(name, value=value) for name, value in wanted]))
    assert dict(table.items()) == before
