"""The pace of simulated time on the wall clock."""

from hypothesis import given
from hypothesis import strategies as st

from bdt_plant.pace import LONGEST_LAG, Pace

PERIOD = 0.002


def released(pace, wall_times, begin=0.0):
    """Return how many measurements of 500 Hz are due over some looks at the wall clock."""
    count = 0
    for now in wall_times:
        while count < 100_000 and pace.is_due(begin + count * PERIOD, now):
            count += 1
    return count


def test_without_a_pace_everything_is_due():
    assert Pace().is_due(1e6, 0.0)


@given(pace=st.floats(0.1, 10.0), look=st.floats(0.001, 0.02), begin=st.floats(0.0, 1e4))
def test_simulated_time_goes_at_its_pace_however_often_somebody_looks(pace, look, begin):
    looks = [n * look for n in range(int(2.0 / look))]
    count = released(Pace(pace), looks, begin)
    assert abs(count * PERIOD - looks[-1] * pace) <= 2 * PERIOD


def test_a_plant_that_was_slow_for_long_does_not_race_to_make_up_for_it():
    pace = Pace(1.0)
    released(pace, [0.0])
    assert released(pace, [5.0], begin=PERIOD) == 1


def test_a_short_lag_is_made_up_for():
    pace = Pace(1.0)
    assert released(pace, [0.0, 0.9 * LONGEST_LAG]) == int(0.9 * LONGEST_LAG / PERIOD) + 1


def test_from_its_pause_on_nothing_is_due_until_the_pause_is_set_later():
    pace = Pace(0.0, pause_at=1.0)
    assert pace.is_due(0.998, 0.0)
    assert not pace.is_due(1.0, 1e9)
    pace.configure(0.0, 1.002)
    assert pace.is_due(1.0, 1e9)
    assert not pace.is_due(1.002, 1e9)


def test_after_a_pause_time_goes_on_at_the_pace_from_there():
    pace = Pace(1.0, pause_at=0.5)
    released(pace, [n * 0.01 for n in range(60)])
    pace.configure(1.0, 1e9)
    assert released(pace, [100.0, 100.1], begin=0.5) in {50, 51}
