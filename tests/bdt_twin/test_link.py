"""The slow link: what arrives when, in simulated time."""

from itertools import islice

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_twin.link import (
    PAPER_LINK,
    DelayedLink,
    LinkSettings,
    Reconfiguration,
    delays,
    expected_delay,
)

SECOND = 1_000_000_000


def link_with(delay):
    return DelayedLink(LinkSettings(communication_delay=delay))


times = st.lists(st.integers(0, 100), min_size=1, max_size=30).map(sorted)


def test_a_reconfiguration_arrives_after_the_delay_and_not_before():
    link = link_with(1.0)
    assert link.send(5 * SECOND, 4 * SECOND, 1e-5) == 6 * SECOND
    assert link.deliver(6 * SECOND - 1) is None
    assert link.deliver(6 * SECOND) == Reconfiguration(6 * SECOND, 4 * SECOND, 1e-5)


def test_it_arrives_once():
    link = link_with(1.0)
    link.send(0, 0, 1e-5)
    assert link.deliver(SECOND) is not None
    assert link.deliver(SECOND) is None
    assert link.deliver(9 * SECOND) is None


def test_without_delay_it_arrives_at_once():
    link = link_with(0.0)
    assert link.send(7, 3, 1e-5) == 7
    assert link.deliver(7) == Reconfiguration(7, 3, 1e-5)


def test_the_delay_is_rounded_to_nanoseconds():
    assert 1.001 * 1e9 < 1_001_000_000  # so truncation would be one off
    assert link_with(1.001).send(0, 0, 0.0) == 1_001_000_000


def test_of_several_that_arrived_the_newest_estimate_counts():
    link = link_with(1.0)
    link.send(0, 30, 3e-5)
    link.send(1, 10, 1e-5)
    link.send(2, 20, 2e-5)
    assert link.deliver(2 * SECOND) == Reconfiguration(SECOND, 30, 3e-5)
    assert link.deliver(9 * SECOND) is None  # the older ones are forgotten


def test_what_is_still_on_its_way_stays_there():
    link = link_with(1.0)
    link.send(0, 0, 1e-5)
    link.send(SECOND, SECOND, 2e-5)
    assert link.deliver(SECOND) == Reconfiguration(SECOND, 0, 1e-5)
    assert link.deliver(2 * SECOND) == Reconfiguration(2 * SECOND, SECOND, 2e-5)


def test_an_older_estimate_that_comes_late_is_dropped():
    link = link_with(0.0)
    link.send(5, 1, 1e-5)
    link.send(3, 2, 2e-5)
    assert link.deliver(4) == Reconfiguration(3, 2, 2e-5)
    assert link.deliver(6) is None
    link.send(7, 3, 3e-5)
    assert link.deliver(7) == Reconfiguration(7, 3, 3e-5)


def test_dead_zone_and_voltage_offset_travel_together():
    link = link_with(0.0)
    link.send(5, 1, 1e-5, -0.01)
    link.send(3, 2, 2e-5, -0.02)
    link.send(4, 3, 3e-5)
    assert link.deliver(3) == Reconfiguration(3, 2, 2e-5, -0.02)
    assert link.deliver(4) == Reconfiguration(4, 3, 3e-5, None)
    assert link.deliver(5) is None, "overtaken, and with it its offset"


def test_what_is_in_force_is_sent_again_with_the_last_voltage_offset_that_was_delivered():
    link = link_with(0.0)
    link.send(1, 1, 1e-5, -0.01)
    link.deliver(1)
    link.send(2, 2, 2e-5, -0.02)
    link.send(3, 3, 3e-5)
    link.deliver(3)
    link.send_again(4)
    assert link.deliver(4) == Reconfiguration(4, 4, 3e-5, -0.01)


def test_after_dropping_everything_older_estimates_count_again():
    """Simulated time may have begun anew."""
    link = link_with(0.0)
    link.send(5, 5, 1e-5)
    link.deliver(5)
    link.restart()
    link.send(1, 1, 2e-5)
    assert link.deliver(1) == Reconfiguration(1, 1, 2e-5)


def test_the_next_arrival_is_known():
    link = link_with(1.0)
    assert link.next_due() is None
    link.send(5, 0, 1e-5)
    link.send(3, 0, 1e-5)
    assert link.next_due() == SECOND + 3
    link.deliver(SECOND + 3)
    assert link.next_due() == SECOND + 5
    link.deliver(SECOND + 5)
    assert link.next_due() is None


def test_dropping_forgets_everything_on_its_way():
    link = link_with(1.0)
    link.send(0, 0, 1e-5)
    link.restart()
    assert link.next_due() is None
    assert link.deliver(9 * SECOND) is None


@given(times)
def test_a_link_asked_at_every_instant_delivers_everything_in_order(sent):
    link = link_with(10e-9)
    for number, now in enumerate(sent):
        link.send(now, number, 0.0)
    arrived = [found for now in range(200) if (found := link.deliver(now))]
    newest = {now: number for number, now in enumerate(sent)}
    assert [(found.due, found.estimated) for found in arrived] == [
        (now + 10, number) for now, number in newest.items()
    ]


# Delays --------------------------------------------------------------------------------------


def drawn(count=20_000, **settings):
    return np.array(list(islice(delays(LinkSettings(**settings)), count)))


def test_the_paper_s_delay_is_always_one_second():
    assert set(islice(delays(PAPER_LINK), 10)) == {1.0}
    assert expected_delay(PAPER_LINK) == 1.0


def test_uniform_delays_have_the_mean_and_the_width_that_are_set():
    sample = drawn(communication_delay=2.0, delay_distribution="uniform", delay_spread=0.5)
    assert 1.0 <= sample.min() < 1.01
    assert 2.99 < sample.max() <= 3.0
    assert sample.mean() == pytest.approx(2.0, abs=0.02)


def test_log_normal_delays_have_the_median_and_the_spread_that_are_set():
    sample = drawn(communication_delay=0.5, delay_distribution="log_normal", delay_spread=0.8)
    assert np.median(sample) == pytest.approx(0.5, rel=0.03)
    assert np.log(sample).std() == pytest.approx(0.8, rel=0.03)


def test_a_table_of_delays_is_used_over_and_over():
    sample = drawn(5, delay_distribution="table", delay_table=(0.1, 3.0))
    assert sample.tolist() == [0.1, 3.0, 0.1, 3.0, 0.1]
    table = LinkSettings(delay_distribution="table", delay_table=(0.1, 3.0))
    assert expected_delay(table) == pytest.approx(1.55)


def test_the_same_seed_draws_the_same_delays_and_another_one_others():
    settings = {"delay_distribution": "uniform", "delay_spread": 1.0}
    first, again = drawn(10, **settings), drawn(10, **settings)
    assert first.tolist() == again.tolist()
    assert drawn(10, link_seed=2, **settings).tolist() != first.tolist()


def test_the_share_of_lost_messages_is_the_one_set_and_losses_do_not_change_delays():
    settings = {"delay_distribution": "uniform", "delay_spread": 1.0}
    lossy = DelayedLink(LinkSettings(request_loss=0.3, **settings))
    whole = DelayedLink(LinkSettings(**settings))
    pairs = [(lossy.send(0, n, 0.0), whole.send(0, n, 0.0)) for n in range(5000)]
    assert lossy.lost == sum(arrival is None for arrival, _ in pairs)
    assert lossy.lost / 5000 == pytest.approx(0.3, abs=0.03)
    assert all(arrival in (None, sent) for arrival, sent in pairs)
    assert whole.lost == 0


def test_what_was_overtaken_is_counted():
    link = DelayedLink(LinkSettings(delay_distribution="table", delay_table=(3.0, 1.0)))
    link.send(0, 1, 1e-5)
    link.send(0, 2, 2e-5)
    assert link.deliver(SECOND).tolerance == 2e-5
    assert link.deliver(3 * SECOND) is None
    assert link.overtaken == 1


@given(
    st.lists(st.floats(0.0, 3.0), min_size=1, max_size=8),
    st.integers(1, 20),
    st.lists(st.booleans(), min_size=1, max_size=40),
)
def test_nothing_arrives_before_the_promise(table, tenths, learned):
    """Whichever of the batches to come lead to a message."""
    batch = tenths * SECOND // 10
    link = DelayedLink(LinkSettings(delay_distribution="table", delay_table=tuple(table)))
    end = 0
    for message in learned:
        promise = link.earliest_arrival(end, batch)
        ahead = DelayedLink(LinkSettings(delay_distribution="table", delay_table=tuple(table)))
        ahead.__dict__ |= {"_drawn": link._drawn.copy(), "_delays": iter([9.0] * 999)}
        arrivals = [ahead.send(end + (n + 1) * batch, n, 0.0) for n in range(len(link._drawn))]
        assert min(arrivals) >= promise
        end += batch
        if message:
            assert link.send(end, end, 0.0) >= promise


@pytest.mark.parametrize(
    ("fault", "text"),
    [
        ({"communication_delay": -0.1}, r"communication_delay = -0\.1 s: must be 0 to 10000 s"),
        ({"communication_delay": float("nan")}, r"communication_delay = nan s: must be 0 to"),
        ({"delay_distribution": "pareto"}, r"must be one of fixed, uniform, log_normal, table"),
        ({"delay_distribution": "uniform", "delay_spread": 1.5}, r"delay_spread = 1\.5: .*0 to 1"),
        ({"delay_table": ()}, r"delay_table = \[\]: must have at least one delay"),
        ({"delay_table": (1.0, -1.0)}, r"delay_table\[1\] = -1\.0 s: must be 0 to"),
        ({"request_loss": 1.1}, r"request_loss = 1\.1: must be 0 to 1"),
        ({"link_seed": 1.0}, r"link_seed = 1\.0: must be an integer"),
    ],
)
def test_a_fault_is_named_with_its_value_and_what_is_allowed(fault, text):
    with pytest.raises(ValueError, match=text):
        LinkSettings(**fault)


def test_what_was_in_force_before_is_sent_again_and_is_older_than_whatever_is_learned():
    link = link_with(1.0)
    link.resume(2e-5, -0.02, (("pid.integral", 3.0),))
    assert link.deliver(9 * SECOND) is None, "nobody asked for it"
    assert link.send_again(5 * SECOND) == 6 * SECOND
    link.send(5 * SECOND, 1, 3e-5)
    assert link.deliver(6 * SECOND - 1) is None
    assert link.deliver(6 * SECOND).tolerance == 3e-5
    link.restart()
    assert link.in_force is None
    link.resume(2e-5, -0.02, (("pid.integral", 3.0),))
    link.send_again(7 * SECOND)
    expected = Reconfiguration(8 * SECOND, 0, 2e-5, -0.02, (("pid.integral", 3.0),))
    assert link.deliver(8 * SECOND) == expected


def test_another_delay_holds_for_what_is_sent_from_then_on():
    link = DelayedLink(LinkSettings(communication_delay=1.0))
    assert link.send(0, 0, 1e-5) == SECOND
    link.use(LinkSettings(communication_delay=0.25))
    assert link.send(0, 1, 2e-5) == SECOND // 4
    assert link.expected_delay == 0.25
