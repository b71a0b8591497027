"""From an estimate to a dead zone on its way."""

import math

import pytest

from bdt_twin.dead_zone_tolerance import DeadZoneRule, DeadZoneSettings
from bdt_twin.estimator import Estimate
from bdt_twin.link import DelayedLink, LinkSettings, Reconfiguration
from bdt_twin.reconfiguration import Reconfigurator

SECOND = 1_000_000_000
PITCH = 1e-3 / (2 * math.pi)


def reconfigurator(delay=2.0, **dead_zone):
    rule = DeadZoneRule(DeadZoneSettings(**dead_zone), PITCH)
    return Reconfigurator(rule, DelayedLink(LinkSettings(communication_delay=delay)))


def test_an_estimate_becomes_the_dead_zone_of_the_time_at_which_it_arrives():
    twin = reconfigurator(coverage_factor=2.0)
    sent = twin.send(Estimate(4.0, 0.2, uncertainty=0.01, growth=0.001), 5 * SECOND)
    assert twin.next_due() == 7 * SECOND
    assert twin.deliver(7 * SECOND - 1) is None
    tolerance = PITCH * (0.2 + 0.02 + 0.001 * 3.0)
    arrived = twin.deliver(7 * SECOND)
    assert arrived == Reconfiguration(7 * SECOND, 5 * SECOND, pytest.approx(tolerance))
    assert sent == arrived.tolerance


def test_the_voltage_offset_arrives_with_the_dead_zone():
    twin = reconfigurator()
    tolerance = twin.send(Estimate(4.0, 0.2), 5 * SECOND, -0.02)
    assert twin.deliver(7 * SECOND) == Reconfiguration(7 * SECOND, 5 * SECOND, tolerance, -0.02)


def test_what_was_sent_is_told_even_if_it_gets_lost():
    rule = DeadZoneRule(DeadZoneSettings(), PITCH)
    twin = Reconfigurator(rule, DelayedLink(LinkSettings(request_loss=1.0)))
    assert twin.send(Estimate(4.0, 0.2), 5 * SECOND) == PITCH * 0.2
    assert twin.next_due() is None


def test_nothing_is_sent_while_nothing_is_known():
    twin = reconfigurator()
    nothing = Estimate(4.0, math.nan, math.inf, reason="the screw did not turn")
    assert twin.send(nothing, 5 * SECOND) is None
    assert twin.next_due() is None


def test_another_run_knows_nothing_of_the_one_before():
    twin = reconfigurator(delay=0.0, rate_limit=1e-6)
    twin.send(Estimate(50.0, 0.1), 50 * SECOND)
    assert twin.deliver(50 * SECOND) is not None
    twin.send(Estimate(51.0, 0.1), 51 * SECOND)
    twin.restart()
    assert twin.next_due() is None
    twin.send(Estimate(1.0, 0.3), SECOND)
    assert twin.deliver(SECOND).tolerance == PITCH * 0.3
