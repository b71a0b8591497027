"""The state file of a twin: whole or not at all, and of use only to the twin that it is of."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_plant.plant import PlantModel
from bdt_plant.structure import StructureParameters
from bdt_twin.machine_knowledge import EFFECTS, MachineKnowledge
from bdt_twin.machine_recollection import MachineRecollection
from bdt_twin.state_file import FUTURE, StateFileError, read_state, write_state
from bdt_twin.twin_state import CONSTANTS, RememberedGap, TwinState, mechanism_of

CONTROLLER = "/controller"
MECHANISM = mechanism_of("output_error", PlantModel())
DAY = 86400.0
NOW = 1_800_000_000.0

STATE = TwinState(
    CONTROLLER,
    MECHANISM,
    2.5e-5,
    -0.02,
    (("pid.proportional", 6284.7), ("notch.frequency", 27.0)),
    ("0102ff",),
    RememberedGap(0.2, 0.01, 1e-4, 2e-5, 0.5),
    MachineRecollection(
        MachineKnowledge(np.linspace(-1.0, 1.0, CONSTANTS), 1e-4 * np.eye(CONSTANTS)),
        frozenset({"voltage_offset", "friction_voltage"}),
        8,
        has_offset=True,
    ),
)

finite = st.floats(allow_nan=False, allow_infinity=False)


def read(path, now=NOW, longest_age=DAY, controller=CONTROLLER, mechanism=MECHANISM):
    return read_state(path, controller, mechanism, now, longest_age)


def assert_same(found, expected):
    assert replace(found, machine=None) == replace(expected, machine=None)
    if expected.machine is None:
        assert found.machine is None
        return
    assert found.machine[1:] == expected.machine[1:]
    for one, other in zip(found.machine.machine, expected.machine.machine, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "twin.json"


def test_what_was_written_is_read_back_with_its_age(path):
    write_state(path, STATE, NOW - 12.5)
    state, age = read(path)
    assert_same(state, STATE)
    assert age == 12.5


@given(
    tolerance=st.floats(0.0, 1.0),
    offset=st.none() | finite,
    gains=st.dictionaries(st.text(), finite),
    gap=st.none()
    | st.builds(
        RememberedGap, finite, st.floats(min_value=0.0, allow_nan=False), finite, finite, finite
    ),
)
def test_every_number_is_read_back_bit_for_bit(tmp_path_factory, tolerance, offset, gains, gap):
    path = tmp_path_factory.mktemp("state") / "twin.json"
    state = TwinState(CONTROLLER, MECHANISM, tolerance, offset, tuple(gains.items()), (), gap)
    write_state(path, state, NOW)
    assert_same(read(path).state, state)


def test_the_file_is_strict_json_for_other_programs(path):
    unsure = replace(STATE, gap=RememberedGap(0.2, float("inf"), 0.0, 0.0, 0.0))
    write_state(path, unsure, NOW)

    def refuse(word):
        raise AssertionError(word)

    whole = json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)
    assert whole["state"]["in_force"]["dead_zone_tolerance"] == STATE.tolerance
    assert_same(read(path).state, unsure)


def test_no_file_is_no_state_and_no_error(path):
    assert read(path) is None


def test_a_torn_file_is_told_wherever_it_is_torn_and_may_be_written_anew(path):
    write_state(path, STATE, NOW)
    whole = path.read_bytes()
    for length in (0, 1, 10, 40, len(whole) // 2, len(whole) - 3):
        path.write_bytes(whole[:length])
        with pytest.raises(StateFileError, match="torn or damaged") as caught:
            read(path)
        assert not caught.value.is_foreign
        assert "\n" not in str(caught.value)


@given(place=st.integers(min_value=40), bit=st.integers(0, 7))
def test_a_flipped_bit_is_never_believed(tmp_path_factory, place, bit):
    path = tmp_path_factory.mktemp("state") / "twin.json"
    write_state(path, STATE, NOW)
    data = bytearray(path.read_bytes().rstrip())
    place = 40 + place % (len(data) - 40)
    data[place] ^= 1 << bit
    path.write_bytes(data)
    try:
        stored = read(path)
    except StateFileError:
        return
    # What still has its checksum is the same: white space between two words.
    assert_same(stored.state, STATE)


@pytest.mark.parametrize("content", [b"plant:\n  ros__parameters: {}\n", b'{"format": "other"}'])
def test_somebody_else_s_file_is_foreign_and_must_not_be_overwritten(path, content):
    path.write_bytes(content)
    with pytest.raises(StateFileError, match="is not the state file of a twin") as caught:
        read(path)
    assert caught.value.is_foreign


def test_the_state_of_another_loop_must_not_be_overwritten(path):
    write_state(path, STATE, NOW)
    with pytest.raises(StateFileError, match="controller /controller, not /left/") as caught:
        read(path, controller="/left/controller")
    assert caught.value.is_foreign


def test_the_state_of_another_mechanism_is_of_no_use(path):
    write_state(path, STATE, NOW)
    heavier = PlantModel(structure=StructureParameters(mass=6.0))
    with pytest.raises(StateFileError, match=r"structure\.mass was 5\.2, is 6\.0") as caught:
        read(path, mechanism=mechanism_of("output_error", heavier))
    assert not caught.value.is_foreign
    with pytest.raises(StateFileError, match=r"estimator\.kind was output_error, is inverse"):
        read(path, mechanism=mechanism_of("inverse_filter", PlantModel()))


def test_a_state_is_of_use_up_to_its_longest_age(path):
    write_state(path, STATE, NOW - 10.0)
    assert read(path, longest_age=10.0).age == 10.0
    with pytest.raises(StateFileError, match="is 10 s old: must be 9 s at most"):
        read(path, longest_age=9.0)


def test_a_clock_that_was_set_back_by_little_makes_a_state_new_by_much_useless(path):
    write_state(path, STATE, NOW + FUTURE)
    assert read(path).age == 0.0
    with pytest.raises(StateFileError, match="the clock was set back"):
        read(path, now=NOW - 1.0)


def test_a_file_that_cannot_be_read_is_told(path):
    path.mkdir()
    with pytest.raises(StateFileError, match="cannot be read: Is a directory"):
        read(path)


def test_what_cannot_be_written_leaves_the_state_before_and_nothing_else(path, monkeypatch):
    write_state(path, STATE, NOW)

    def full(_descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        write_state(path, replace(STATE, tolerance=9e-5), NOW)
    assert_same(read(path).state, STATE)
    assert list(path.parent.iterdir()) == [path]


WRITE_FOR_EVER = """
import sys
from itertools import count
from pathlib import Path
from dataclasses import replace

sys.path.insert(0, sys.argv[2])
from test_state_file import NOW, STATE
from bdt_twin.state_file import write_state

for number in count(1):
    write_state(Path(sys.argv[1]), replace(STATE, tolerance=number * 1e-9), NOW)
"""


def test_a_process_that_is_killed_while_it_writes_leaves_a_whole_state(path):
    """Each of the kills comes at another time; a state that is there was whole before."""
    before = 0.0
    for _ in range(5):
        path.unlink(missing_ok=True)
        words = [sys.executable, "-c", WRITE_FOR_EVER, str(path), str(Path(__file__).parent)]
        process = subprocess.Popen(words)
        end = time.monotonic() + 60.0
        while not path.exists():
            assert process.poll() is None
            assert time.monotonic() < end
        process.send_signal(signal.SIGKILL)
        process.wait()
        before = read(path).state.tolerance
        assert before > 0.0


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"tolerance": -1e-6}, "TwinState.tolerance = -1e-06: must be 0 to 1 m"),
        ({"tolerance": float("nan")}, "TwinState.tolerance = nan"),
        ({"voltage_offset": float("inf")}, "TwinState.voltage_offset = inf: must be finite"),
        ({"gains": (("pid.integral", float("nan")),)}, "TwinState.pid.integral = nan"),
        ({"gap": RememberedGap(float("nan"), 0.0, 0.0, 0.0, 0.0)}, "TwinState.gap = nan"),
    ],
)
def test_a_state_that_cannot_be_is_none(change, says):
    with pytest.raises(ValueError, match=says.replace(".", r"\.")):
        replace(STATE, **change)


@given(
    uncertainty=st.floats(0.0, 1.0),
    growth=st.floats(-1e-3, 1e-3),
    doubt=st.floats(0.0, 1e-3),
    ages=st.tuples(st.floats(0.0, 1e6), st.floats(0.0, 1e6)),
)
def test_a_gap_gets_as_unsure_as_it_may_have_grown(uncertainty, growth, doubt, ages):
    begin = RememberedGap(0.2, uncertainty, growth, doubt, 0.0)
    aged = begin.aged(ages[0])
    expected = np.sqrt(uncertainty**2 + (growth * ages[0]) ** 2 + (doubt * ages[0]) ** 2)
    assert aged.grown_uncertainty == pytest.approx(expected)
    assert (aged.gap, aged.age) == (0.2, ages[0])
    assert aged.aged(ages[1]) == begin.aged(ages[0] + ages[1])


def test_a_machine_with_other_constants_is_not_believed(path):
    write_state(path, STATE, NOW)
    whole = json.loads(path.read_text(encoding="utf-8"))
    assert whole["state"]["machine"]["constants"][-len(EFFECTS) :] == list(EFFECTS)
    with pytest.raises(ValueError, match="constants and their covariance"):
        from_document(whole["state"], expected=[0.0])
    with pytest.raises(ValueError, match="must be finite"):
        from_document(whole["state"], expected=["nan"] * CONSTANTS)
    with pytest.raises(ValueError, match="are not those of this version"):
        from_document(whole["state"], constants=["gain"])
    with pytest.raises(ValueError, match="positive diagonal"):
        from_document(whole["state"], covariance=[[0.0] * CONSTANTS] * CONSTANTS)


def from_document(document, **machine):
    from bdt_twin.twin_state import state_from

    return state_from({**document, "machine": {**document["machine"], **machine}})
