"""The stepwise constant reference, above all at the boundaries of its steps."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_controller.reference import ReferenceProfile, reference_at

FIRST, SECOND = 5e-3, -1e-3

steps = st.integers(0, 100_000)
step_times = st.sampled_from([0.1, 0.3, 0.7, 1.1, 1 / 3, 2.0, 10.0])


def square(step_time):
    return ReferenceProfile(kind="square", first=FIRST, second=SECOND, step_time=step_time)


def level(step):
    return SECOND if step % 2 else FIRST


@given(steps, step_times)
def test_a_step_of_the_square_wave_begins_at_its_nominal_time(step, step_time):
    assert reference_at(square(step_time), step * step_time) == level(step)


@given(steps, step_times)
def test_a_step_of_the_square_wave_lasts_until_the_next_one(step, step_time):
    reference = square(step_time)
    assert reference_at(reference, (step + 0.5) * step_time) == level(step)
    assert reference_at(reference, (step + 1) * step_time - 1e-6) == level(step)


def test_measurements_at_500_hz_see_every_step_of_0_1_s_exactly_50_times():
    reference = square(0.1)
    seen = [reference_at(reference, sample / 500) for sample in range(5000)]
    assert seen == [level(sample // 50) for sample in range(5000)]


def test_times_that_were_added_up_see_the_same_steps():
    time, reference = 0.0, square(0.1)
    for sample in range(100):  # 0.1 added ten times is 0.9999999999999999
        assert reference_at(reference, time) == level(sample)
        time += 0.1


def test_the_default_is_the_square_wave_of_the_scenario():
    seen = [reference_at(ReferenceProfile(), time) for time in (0.0, 9.99, 10.0, 19.99, 20.0)]
    assert seen == [5e-3, 5e-3, 0.0, 0.0, 5e-3]


def table(*rows):
    times, positions = zip(*rows, strict=True)
    return ReferenceProfile(kind="table", table_times=times, table_positions=positions)


@given(st.integers(1, 1000))
def test_a_step_of_the_table_begins_at_its_time(count):
    reference = table(*((index * 0.1, index * 1e-3) for index in range(count)))
    for index in {0, count // 2, count - 1}:
        assert reference_at(reference, index * 0.1) == index * 1e-3
        assert reference_at(reference, (100 * index) / 1000) == index * 1e-3
        assert reference_at(reference, (index + 0.5) * 0.1) == index * 1e-3
        assert reference_at(reference, (index + 1) * 0.1 - 1e-6) == index * 1e-3


def test_before_the_first_step_of_the_table_the_reference_is_zero():
    reference = table((1.0, 2e-3), (2.0, 3e-3))
    seen = [reference_at(reference, time) for time in (0.0, 0.999, 1.0, 1.999, 2.0, 1e6)]
    assert seen == [0.0, 0.0, 2e-3, 2e-3, 3e-3, 3e-3]


def test_a_reference_from_a_topic_has_no_value_of_its_own():
    with pytest.raises(ValueError, match=r"ReferenceProfile\.kind = 'topic'"):
        reference_at(ReferenceProfile(kind="topic"), 0.0)


@pytest.mark.parametrize(
    ("fault", "text"),
    [
        ({"kind": "sine"}, r"kind = 'sine': must be one of square, table, commissioning, topic"),
        ({"first": float("nan")}, r"first = nan m: must be -1000 to 1000 m"),
        ({"second": float("-inf")}, r"second = -inf m: must be -1000 to 1000 m"),
        ({"step_time": 0.0}, r"step_time = 0\.0 s: must be 0\.001 to 1e\+09 s"),
        ({"first": "5 mm"}, r"first = '5 mm': must be a number, -1000 to 1000 m"),
        ({"table_times": (-1.0,)}, r"table_times\[0\] = -1\.0 s: must be 0 to 1e\+09 s"),
        ({"table_positions": (0.0, 1.0)}, r"table_positions has 2 values: .* table_times \(1\)"),
        ({"table_times": (), "table_positions": ()}, r"table_positions has 0 values: .* one"),
        (
            {"table_times": (0.0, 0.0), "table_positions": (0.0, 1.0)},
            r"table_times = \[0\.0, 0\.0\]: must be strictly increasing",
        ),
    ],
)
def test_a_fault_is_named_with_its_value_and_what_is_allowed(fault, text):
    with pytest.raises(ValueError, match=r"^ReferenceProfile\." + text):
        ReferenceProfile(**fault)
