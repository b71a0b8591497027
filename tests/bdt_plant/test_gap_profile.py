"""Every law of growth of the gap against its formula, and its errors."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_plant.gap_profile import KINDS, GapProfile, gap_at, gaps_at

times = st.floats(0, 1e4)
table = st.lists(st.tuples(st.floats(0, 1e4), st.floats(0, 10)), min_size=1, max_size=8)


@given(times)
def test_a_constant_gap_is_the_initial_one(time):
    assert gap_at(GapProfile(kind="constant", initial=0.3, final=9.0), time) == 0.3


@given(st.floats(0, 50))
def test_a_ramp_grows_evenly(time):
    profile = GapProfile(kind="ramp", initial=0.1, final=0.6, growth_time=50.0)
    assert gap_at(profile, time) == pytest.approx(0.1 + time / 100, abs=1e-15)


@given(st.floats(0, 50), st.floats(0.1, 10))
def test_a_power_law_grows_with_the_power_of_time(time, exponent):
    profile = GapProfile(
        kind="power_law", initial=0.1, final=0.6, growth_time=50.0, exponent=exponent
    )
    expected = 0.1 + 0.5 * math.pow(time / 50.0, exponent)
    assert gap_at(profile, time) == pytest.approx(expected, abs=1e-15)


def test_a_gap_may_shrink():
    profile = GapProfile(kind="ramp", initial=0.6, final=0.1, growth_time=50.0)
    assert gap_at(profile, 25.0) == pytest.approx(0.35)


@given(table, times)
def test_a_table_is_joined_by_straight_lines(rows, time):
    rows = sorted({int(t): gap for t, gap in rows}.items())
    profile = GapProfile(
        kind="table",
        table_times=tuple(float(t) for t, _ in rows),
        table_gaps=tuple(gap for _, gap in rows),
    )
    gap = gap_at(profile, time)
    before = [row for row in rows if row[0] <= time]
    after = [row for row in rows if row[0] > time]
    if before and after:
        (t_0, gap_0), (t_1, gap_1) = before[-1], after[0]
        assert gap == pytest.approx(gap_0 + (gap_1 - gap_0) * (time - t_0) / (t_1 - t_0), abs=1e-12)
    else:  # constant beyond both ends
        assert gap == (before[-1] if before else after[0])[1]


@pytest.mark.parametrize("kind", ["ramp", "power_law"])
def test_growth_begins_at_the_initial_gap_and_stays_at_the_final_one(kind):
    profile = GapProfile(kind=kind, initial=0.1, final=0.6, growth_time=50.0)
    assert gap_at(profile, 0.0) == 0.1
    assert gap_at(profile, -1.0) == 0.1
    assert gap_at(profile, 50.0) == pytest.approx(0.6, abs=1e-15)
    assert gap_at(profile, 1e6) == gap_at(profile, 50.0)


def test_the_default_has_the_mean_of_ten_degrees_that_the_paper_gives():
    instants = (np.arange(12_000) + 0.5) / 100
    assert np.rad2deg(gaps_at(GapProfile(), instants).mean()) == pytest.approx(10.0, abs=1e-6)


angles = st.floats(0, 100)
profiles = st.builds(
    lambda kind, initial, final, growth_time, exponent, rows: GapProfile(
        kind,
        initial,
        final,
        growth_time,
        exponent,
        tuple(sorted(rows)),
        tuple(rows.values()),
    ),
    st.sampled_from(KINDS),
    angles,
    angles,
    st.floats(1e-3, 1e9),
    st.sampled_from([0.5, 1.0, 2.0, 3.0]) | st.floats(0.1, 10),
    st.dictionaries(times, angles, min_size=1, max_size=8),
)


def assert_same_floats(profile, instants):
    expected = np.array([gap_at(profile, time) for time in instants.tolist()], dtype=np.float64)
    gaps = gaps_at(profile, instants)
    assert gaps.dtype == np.float64
    assert gaps.tobytes() == expected.tobytes()


@given(profiles, st.lists(st.floats(-10, 1e4), max_size=40))
def test_an_array_of_times_gives_the_very_same_floats(profile, instants):
    assert_same_floats(profile, np.array(instants))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.7, 2.0])
@pytest.mark.parametrize("count", [0, 1, 7, 64, 5001])
def test_arrays_of_any_length_give_the_very_same_floats(kind, exponent, count):
    """Whatever works on several numbers at a time treats the ends of an array otherwise."""
    profile = GapProfile(kind, initial=0.1, exponent=exponent)
    assert_same_floats(profile, np.random.default_rng(3).uniform(-10, 200, count))


def test_angles_that_are_whole_numbers_make_floats():
    for kind in KINDS:
        profile = GapProfile(kind, 0, 1, 120, 2, (0, 120), (0, 1))
        assert_same_floats(profile, np.arange(-1.0, 130.0))


@pytest.mark.parametrize(
    ("fault", "text"),
    [
        ({"kind": "cubic"}, r"kind = 'cubic': must be one of constant, ramp, power_law, table"),
        ({"kind": 3}, r"kind = 3: must be one of constant, ramp, power_law, table"),
        ({"initial": -0.1}, r"initial = -0\.1 rad: must be 0 to 100 rad"),
        ({"initial": float("nan")}, r"initial = nan rad: must be 0 to 100 rad"),
        ({"final": float("inf")}, r"final = inf rad: must be 0 to 100 rad"),
        ({"growth_time": 0.0}, r"growth_time = 0\.0 s: must be 0\.001 to 1e\+09 s"),
        ({"exponent": 0.0}, r"exponent = 0\.0 ?: must be 0\.1 to 10"),
        ({"exponent": True}, r"exponent = True: must be a number, 0\.1 to 10"),
        ({"table_times": 3.0}, r"table_times = 3\.0: must be a list"),
        ({"table_times": "0, 1"}, r"table_times = '0, 1': must be a list"),
        ({"table_times": (0.0, "1")}, r"table_times\[1\] = '1': must be a number, 0 to 1e\+09 s"),
        ({"table_gaps": (0.0, float("nan"))}, r"table_gaps\[1\] = nan rad: must be 0 to 100 rad"),
        ({"table_gaps": (0.0,)}, r"table_gaps has 1 values: .* as table_times \(2\)"),
        ({"table_times": (), "table_gaps": ()}, r"table_gaps has 0 values: .* at least one"),
        ({"table_times": (1.0, 1.0)}, r"table_times = \[1\.0, 1\.0\]: .* strictly increasing"),
        ({"table_times": (2.0, 1.0)}, r"table_times = \[2\.0, 1\.0\]: .* strictly increasing"),
    ],
)
def test_a_fault_is_named_with_its_value_and_what_is_allowed(fault, text):
    with pytest.raises(ValueError, match=r"^GapProfile\." + text):
        GapProfile(**fault)


def test_a_growth_that_begins_later_is_the_same_growth_later():
    times = np.array([0.0, 30.0, 40.0, 65.0, 500.0])
    for kind in KINDS:
        later = gaps_at(GapProfile(kind, 0.1, growth_time=50.0, begin_time=30.0), times)
        now = gaps_at(GapProfile(kind, 0.1, growth_time=50.0), np.maximum(times - 30.0, 0.0))
        np.testing.assert_array_equal(later, now)
