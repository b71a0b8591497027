"""Decisions of a twin that simulates, as its diagnostics in a bag tell them."""

import numpy as np
import pytest
from recorded_loops import diagnostics

from bdt_bags.reading.recording import load_recording
from bdt_msgs_py.topics import DIAGNOSTICS

TIME = np.arange(0.0, 10.0, 0.01)

TOLD = {
    "decision": "simulate",
    "decision_reason": "narrowest",
    "decision_ratio": "0.6",
    "expected_bias_percent": "0.7",
    "expected_settling_s": "2.1",
    "decisions_taken_back": "0",
}


@pytest.fixture
def signal(signal_messages):
    return signal_messages(TIME, np.sin(TIME), [(0.0, 1.0)])


def say(signal, time, node="/twin", **changes):
    values = TOLD | changes
    signal.add(DIAGNOSTICS, time, diagnostics(f"{signal.namespace}{node}", time, values))


def decisions(signal, path):
    return load_recording(signal.write(path / "bag")).decisions


def test_decisions_are_those_of_the_twin_that_say_something_new(signal, tmp_path):
    for time in (1.0, 2.0):
        say(signal, time)
    say(signal, 3.0, decision_ratio="nan", decision_reason="taken back", decisions_taken_back="1")
    say(signal, 4.0, node="/other")
    first, second = decisions(signal, tmp_path)
    assert first.time == pytest.approx(1.0, abs=0.1)
    assert (first.ratio, first.expected_bias_percent, first.expected_settling) == (0.6, 0.7, 2.1)
    assert (first.reason, first.taken_back) == ("narrowest", 0)
    assert (second.ratio, second.reason, second.taken_back) == (None, "taken back", 1)


def test_what_is_no_number_is_unknown(signal, tmp_path):
    say(signal, 1.0, expected_bias_percent="much", expected_settling_s="inf", decision_ratio="-1")
    (found,) = decisions(signal, tmp_path)
    assert (found.ratio, found.expected_bias_percent, found.expected_settling) == (None,) * 3


def test_a_twin_that_does_not_simulate_has_decided_nothing(signal, tmp_path):
    say(signal, 1.0, decision="equation_9")
    assert decisions(signal, tmp_path) == ()
