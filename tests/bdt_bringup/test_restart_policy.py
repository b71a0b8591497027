"""How often a node that died is started anew."""

from hypothesis import given
from hypothesis import strategies as st

from bdt_bringup.restart_policy import FIRST_DELAY, MOST_RESTARTS, PERIOD, RestartPolicy


def test_each_restart_within_the_period_waits_twice_as_long():
    policy = RestartPolicy()
    delays = [policy.died(float(second)) for second in range(MOST_RESTARTS)]
    assert delays == [FIRST_DELAY * 2**number for number in range(MOST_RESTARTS)]


def test_a_node_that_dies_too_often_is_given_up():
    policy = RestartPolicy()
    for second in range(MOST_RESTARTS):
        assert policy.died(float(second)) is not None
    assert policy.died(PERIOD - 0.1) is None


def test_a_node_that_has_lived_for_long_begins_anew():
    policy = RestartPolicy()
    for second in range(MOST_RESTARTS):
        policy.died(float(second))
    assert policy.died(MOST_RESTARTS + PERIOD) == FIRST_DELAY


@given(st.lists(st.floats(0.0, 1000.0), max_size=50).map(sorted))
def test_no_period_has_more_restarts_than_allowed(deaths):
    policy = RestartPolicy()
    restarts = [time for time in deaths if policy.died(time) is not None]
    for begin in restarts:
        assert sum(begin <= time < begin + PERIOD for time in restarts) <= MOST_RESTARTS
