"""When platforms are pushed, and in which direction."""

import numpy as np
import pytest

from bdt_plant.pushes import PushParameters, discretize_pushes, push_force

RATE = 1000.0


def forces(seconds, **parameters):
    pushes = discretize_pushes(PushParameters(**parameters), RATE)
    return np.array([push_force(sample, pushes) for sample in range(round(seconds * RATE))])


def test_pushes_come_at_every_period_from_the_first_on_and_take_turns():
    actual = forces(4.0, force=2.0, duration=0.05, period=1.0)
    expected = np.zeros(4000)
    for second, sign in ((1, 1), (2, -1), (3, 1)):
        expected[second * 1000 : second * 1000 + 50] = 2.0 * sign
    assert actual.tolist() == expected.tolist()


def test_by_default_nobody_pushes():
    assert not forces(20.0).any()
    assert not PushParameters().fall_between(0.0, 20.0)


@pytest.mark.parametrize(("begin", "end"), [(0.5, 2.0), (1.0, 2.0), (1.2, 3.0), (3.0, 5.5)])
def test_it_is_told_whether_a_push_falls_into_a_time(begin, end):
    pushes = {"force": 2.0, "duration": 0.001, "period": 1.5}
    begun = np.flatnonzero(forces(6.0, **pushes)) / RATE
    expected = bool(((begun >= begin) & (begun < end)).any())
    assert PushParameters(**pushes).fall_between(begin, end) is expected


def test_a_seed_means_one_sequence_of_directions_with_both_about_as_often():
    one, again, other = (
        forces(1000.0, force=1.0, duration=0.001, period=1.0, seed=seed)[1000::1000]
        for seed in (7, 7, 8)
    )
    assert set(np.abs(one)) == {1.0}
    assert one.tolist() == again.tolist()
    assert abs(np.mean(one)) < 4.4 / np.sqrt(one.size)
    assert abs(np.mean(one * other)) < 4.4 / np.sqrt(one.size)
    assert abs(np.mean(one[1:] * one[:-1])) < 4.4 / np.sqrt(one.size)


@pytest.mark.parametrize(
    ("field", "value"),
    [("force", -1.0), ("platform", 1), ("platform", 4), ("duration", 8.0), ("period", 0.0)],
)
def test_what_no_push_is_is_refused(field, value):
    with pytest.raises(ValueError, match=rf"^PushParameters\.{field} = .*: must be"):
        PushParameters(**{field: value})
