"""The slow link: what arrives when, in simulated time."""

from hypothesis import given
from hypothesis import strategies as st

from bdt_twin.link import DelayedLink, Reconfiguration

SECOND = 1_000_000_000

times = st.lists(st.integers(0, 100), min_size=1, max_size=30).map(sorted)


def test_a_reconfiguration_arrives_after_the_delay_and_not_before():
    link = DelayedLink(1.0)
    assert link.send(5 * SECOND, 4 * SECOND, 1e-5) == 6 * SECOND
    assert link.deliver(6 * SECOND - 1) is None
    assert link.deliver(6 * SECOND) == Reconfiguration(6 * SECOND, 4 * SECOND, 1e-5)


def test_it_arrives_once():
    link = DelayedLink(1.0)
    link.send(0, 0, 1e-5)
    assert link.deliver(SECOND) is not None
    assert link.deliver(SECOND) is None
    assert link.deliver(9 * SECOND) is None


def test_without_delay_it_arrives_at_once():
    link = DelayedLink(0.0)
    assert link.send(7, 3, 1e-5) == 7
    assert link.deliver(7) == Reconfiguration(7, 3, 1e-5)


def test_the_delay_is_rounded_to_nanoseconds():
    assert 1.001 * 1e9 < 1_001_000_000  # so truncation would be one off
    assert DelayedLink(1.001).send(0, 0, 0.0) == 1_001_000_000


def test_of_several_that_arrived_the_newest_estimate_counts():
    link = DelayedLink(1.0)
    link.send(0, 30, 3e-5)
    link.send(1, 10, 1e-5)
    link.send(2, 20, 2e-5)
    assert link.deliver(2 * SECOND) == Reconfiguration(SECOND, 30, 3e-5)
    assert link.deliver(9 * SECOND) is None  # the older ones are forgotten


def test_what_is_still_on_its_way_stays_there():
    link = DelayedLink(1.0)
    link.send(0, 0, 1e-5)
    link.send(SECOND, SECOND, 2e-5)
    assert link.deliver(SECOND) == Reconfiguration(SECOND, 0, 1e-5)
    assert link.deliver(2 * SECOND) == Reconfiguration(2 * SECOND, SECOND, 2e-5)


def test_an_older_estimate_that_comes_late_is_dropped():
    link = DelayedLink(0.0)
    link.send(5, 1, 1e-5)
    link.send(3, 2, 2e-5)
    assert link.deliver(4) == Reconfiguration(3, 2, 2e-5)
    assert link.deliver(6) is None
    link.send(7, 3, 3e-5)
    assert link.deliver(7) == Reconfiguration(7, 3, 3e-5)


def test_after_dropping_everything_older_estimates_count_again():
    """Simulated time may have begun anew."""
    link = DelayedLink(0.0)
    link.send(5, 5, 1e-5)
    link.deliver(5)
    link.drop()
    link.send(1, 1, 2e-5)
    assert link.deliver(1) == Reconfiguration(1, 1, 2e-5)


def test_the_next_arrival_is_known():
    link = DelayedLink(1.0)
    assert link.next_due() is None
    link.send(5, 0, 1e-5)
    link.send(3, 0, 1e-5)
    assert link.next_due() == SECOND + 3
    link.deliver(SECOND + 3)
    assert link.next_due() == SECOND + 5
    link.deliver(SECOND + 5)
    assert link.next_due() is None


def test_dropping_forgets_everything_on_its_way():
    link = DelayedLink(1.0)
    link.send(0, 0, 1e-5)
    link.drop()
    assert link.next_due() is None
    assert link.deliver(9 * SECOND) is None


@given(times)
def test_a_link_asked_at_every_instant_delivers_everything_in_order(sent):
    link = DelayedLink(10e-9)
    for number, now in enumerate(sent):
        link.send(now, number, 0.0)
    arrived = [found for now in range(200) if (found := link.deliver(now))]
    newest = {now: number for number, now in enumerate(sent)}
    assert [(found.due, found.estimated) for found in arrived] == [
        (now + 10, number) for now, number in newest.items()
    ]
