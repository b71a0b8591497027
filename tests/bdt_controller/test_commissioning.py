"""The minute of commissioning: what it shows, and that it stays within its limits."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from bdt_controller.commissioning import DURATION, PLAN, longest_travel_time
from bdt_controller.reference import ReferenceProfile, reference_at

TIMES = np.arange(0.0, DURATION + 5.0, 2e-3)

levels = st.floats(-0.1, 0.1)
speeds = st.floats(1.0, 100.0)


def commissioning(first=5e-3, second=0.0, largest_speed=0.05):
    return ReferenceProfile(
        kind="commissioning", first=first, second=second, largest_speed=largest_speed
    )


def sampled(reference):
    return np.array([reference_at(reference, time) for time in TIMES.tolist()])


@settings(max_examples=25, deadline=None)
@given(levels, levels, speeds)
def test_it_stays_within_travel_and_speed_and_ends_where_it_began(first, second, factor):
    travel = abs(first - second)
    assume(travel >= 1e-6)
    slowest = travel / longest_travel_time()
    reference = commissioning(first, second, 1.000001 * factor * slowest)
    positions = sampled(reference)
    rounding = 1e-12
    assert positions.min() >= min(first, second) - rounding
    assert positions.max() <= max(first, second) + rounding
    assert np.abs(np.diff(positions)).max() <= reference.largest_speed * 2e-3 + rounding
    assert positions[0] == second
    assert np.all(positions[TIMES >= DURATION] == second)
    assert np.ptp(positions) == pytest.approx(travel)


def motions():
    """Return rows (change of level, duration), rests left out."""
    before = [0.0, *(motion.level for motion in PLAN[:-1])]
    return [
        (motion.level - start, motion.duration)
        for motion, start in zip(PLAN, before, strict=True)
        if motion.level != start
    ]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_there_are_steps_of_several_sizes_in_both_directions(sign):
    sizes = {round(abs(change), 9) for change, time in motions() if time == 0.0 < sign * change}
    assert len(sizes) >= 3
    assert max(sizes) >= 0.8


def test_each_slow_motion_is_followed_by_the_same_one_back():
    slow = [(round(change, 9), time) for change, time in motions() if time > 0.0]
    assert slow[1::2] == [(-change, time) for change, time in slow[::2]]
    speeds = {abs(change) / time for change, time in slow}
    assert len(speeds) >= 3
    assert min(speeds) <= 0.05


def test_it_rests_before_between_and_after():
    positions = sampled(commissioning())
    rests = np.diff(positions) == 0.0
    assert rests[TIMES[:-1] < 2.0].all()
    assert rests[(TIMES[:-1] > 53.0)].all()
    assert 20.0 < 2e-3 * np.count_nonzero(rests[TIMES[:-1] < DURATION]) < 40.0


def test_a_step_takes_as_long_as_the_largest_speed_says():
    reference = commissioning(largest_speed=0.02)
    assert reference_at(reference, 2.0) == 0.0
    assert reference_at(reference, 2.125) == pytest.approx(2.5e-3)
    assert reference_at(reference, 2.25) == 5e-3


def test_a_level_that_is_held_is_the_same_float_all_the_time():
    """The controller tells each change of its reference."""
    positions = sampled(commissioning(0.0031, 0.0007))
    assert len(set(positions[(TIMES > 8.0) & (TIMES < 9.5)].tolist())) == 1


@pytest.mark.parametrize(
    ("fault", "text"),
    [
        ({"first": 1e-3, "second": 1e-3}, r"first = 0\.001 m: must differ from second"),
        (
            {"largest_speed": 1e-3},
            r"largest_speed = 0\.001 m/s: must be at least 0\.002 m/s for a travel of 0\.005 m",
        ),
        ({"largest_speed": 0.0}, r"largest_speed = 0\.0 m/s: must be 1e-09 to 1000 m/s"),
        ({"largest_speed": float("nan")}, r"largest_speed = nan m/s: must be 1e-09 to 1000 m/s"),
    ],
)
def test_a_fault_is_named_with_its_value_and_what_is_allowed(fault, text):
    with pytest.raises(ValueError, match=r"^ReferenceProfile\." + text):
        commissioning(**fault)


def test_limits_of_commissioning_are_of_no_account_for_another_kind():
    assert reference_at(ReferenceProfile(first=0.0, largest_speed=1e-9), 0.0) == 0.0
