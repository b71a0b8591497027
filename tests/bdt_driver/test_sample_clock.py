"""Readings have even times, whatever the timer does."""

from hypothesis import given
from hypothesis import strategies as st

from bdt_driver.sample_clock import SampleClock


def test_a_timer_that_is_on_time_gives_every_number():
    clock = SampleClock(500.0)
    assert [clock.tick(7.0 + 0.002 * number) for number in range(5)] == [0, 1, 2, 3, 4]
    assert clock.missed == 0


def test_a_timer_that_is_early_gives_no_number_twice():
    clock = SampleClock(500.0)
    assert [clock.tick(time) for time in (0.0, 0.0005, 0.0018, 0.0022)] == [0, None, 1, None]


def test_what_a_late_timer_leaves_out_is_counted():
    clock = SampleClock(500.0)
    assert [clock.tick(time) for time in (0.0, 0.002, 0.0101)] == [0, 1, 5]
    assert clock.missed == 3


@given(st.lists(st.floats(0.0, 0.01), min_size=1))
def test_every_number_is_that_of_the_nearest_time(delays):
    clock = SampleClock(1000.0)
    now, origin, numbers = 3.0, None, []
    for delay in delays:
        now += delay
        origin = now if origin is None else origin
        number = clock.tick(now)
        if number is not None:
            numbers.append(number)
            assert abs(clock.nanoseconds(number) * 1e-9 - (now - origin)) <= 0.5e-3 + 1e-9
    assert numbers == sorted(set(numbers))
    assert clock.missed == numbers[-1] + 1 - len(numbers)
