"""Samples are told apart by their numbers: new, lost before, been here."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from bdt_serial_drive.messages import SAMPLE_NUMBERS, Samples
from bdt_serial_drive.sample_sequence import SampleSequence


def samples(first, count):
    rows = np.column_stack((np.zeros(count), (first + np.arange(count)) % SAMPLE_NUMBERS))
    return Samples(first % SAMPLE_NUMBERS, False, rows)


def test_the_first_ones_are_new_whatever_their_number():
    assert SampleSequence().placed(samples(12345, 5))[0] == 0


def test_a_doubled_message_is_dropped():
    sequence = SampleSequence()
    sequence.placed(samples(0, 5))
    assert sequence.placed(samples(0, 5)) is None
    assert sequence.placed(samples(5, 5))[0] == 0


def test_of_a_message_that_was_here_in_part_the_rest_is_new():
    sequence = SampleSequence()
    sequence.placed(samples(0, 5))
    lost, rest = sequence.placed(samples(3, 5))
    assert (lost, rest.first, rest.rows[:, 1].tolist()) == (0, 5, [5.0, 6.0, 7.0])


@given(
    st.integers(0, SAMPLE_NUMBERS - 1),
    st.lists(st.tuples(st.integers(1, 31), st.sampled_from(["comes", "lost", "doubled"]))),
)
def test_every_sample_comes_once_or_is_counted_as_lost(first, messages):
    sequence = SampleSequence()
    sequence.placed(samples(first, 1))
    number, came, lost = first + 1, [], 0
    for count, fate in messages:
        for _ in range({"comes": 1, "lost": 0, "doubled": 2}[fate]):
            placed = sequence.placed(samples(number, count))
            if placed is not None:
                lost += placed[0]
                came += placed[1].rows[:, 1].tolist()
        number += count
    assert len(set(came)) == len(came)
    while messages and messages[-1][1] == "lost":
        number -= messages.pop()[0]
    assert len(came) + lost == number - first - 1
