"""The simulations behind the figures: what goes in, and what is found in them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bdt_analysis.metrics.dead_zone_requests import reconfiguration_lags
from bdt_plant.gap_profile import GapProfile
from bdt_study.reproduction.experiments import (
    Choices,
    constant_experiment,
    post_processed_estimates,
    reconfigured_experiment,
)
from bdt_twin.link import LinkSettings

SHORT = replace(Choices(), duration=20.0)
PITCH = 1e-3 / (2 * math.pi)


def test_the_default_choices_are_those_of_the_paper_scenario():
    choices = Choices()
    assert choices.mean_gap == pytest.approx(math.radians(10.0), abs=1e-12)
    assert choices.reference.first == 0.005
    assert choices.settings().velocity_threshold == 0.1


@pytest.mark.parametrize("exponent", [0.5, 1.0, 3.0])
def test_the_mean_gap_is_that_of_the_power_law(exponent):
    profile = GapProfile(final=0.5, exponent=exponent)
    expected = math.degrees(0.5 / (exponent + 1))
    assert math.degrees(Choices(gap=profile).mean_gap) == pytest.approx(expected, abs=0.01)


def test_a_run_says_what_a_recording_would(runs):
    signals = runs.fixed.signals
    assert signals.telemetry.shape == (600_000, 3)
    assert signals.duration == pytest.approx(120.0)
    assert signals.dead_zones.tolist() == [[0.0, pytest.approx(PITCH * math.radians(10.0))]]
    assert signals.reference[:3].tolist() == [[0.0, 0.005], [10.0, 0.0], [20.0, 0.005]]
    assert len(runs.fixed.steps) == 12
    half_way = np.searchsorted(signals.truth[:, 0], 60.0)
    assert signals.truth[half_way, 3] == pytest.approx(math.radians(7.5))
    assert np.rad2deg(runs.fixed.gaps[[5, 11]]) == pytest.approx([7.5, 30.0])


def test_the_dead_zone_of_the_twin_follows_eq_9_and_the_delay():
    run = reconfigured_experiment(SHORT, LinkSettings(communication_delay=1.0))
    estimates, dead_zones = run.signals.estimates, run.signals.dead_zones
    assert dead_zones[0].tolist() == [0.0, 0.0]
    assert np.isin(dead_zones[1:, 1], PITCH * estimates[:, 1]).all()
    lags = reconfiguration_lags(run.signals)[:, 1]
    assert lags.size == len(dead_zones) - 1
    assert lags.min() >= 1.0
    assert lags.max() <= 1.1 + 2e-3


def test_without_backlash_and_dead_zone_every_step_converges():
    run = constant_experiment(replace(SHORT, gap=GapProfile(kind="constant")), 0.0)
    assert not run.limit_cycles.any()
    assert run.residuals.max() < 1e-6
    assert run.biases.max() < 1e-3


def test_post_processed_estimates_belong_to_the_middle_of_their_window(runs):
    early = post_processed_estimates(replace(runs.choices, window=1.0), runs.fixed.loop)
    late = post_processed_estimates(replace(runs.choices, window=2.0), runs.fixed.loop)
    # Same newest samples, so the middles differ by half of the difference of the windows.
    assert early[-1, 0] - late[-1, 0] == pytest.approx(0.5)
