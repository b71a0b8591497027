"""Settings that contradict each other are refused in one line."""

import pytest

from bdt_twin.output_error_settings import OutputErrorSettings


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"knot_spacing": 30.0}, r"knot_spacing = 30.0 s: must be at most the window \(20 s\)"),
        ({"shortest_stretch": 30.0}, "shortest_stretch = 30.0 s: must be at most the window"),
        ({"window": 0.0}, "window = 0.0 s: must be 1 to 1000 s"),
    ],
)
def test_a_contradiction_is_refused(changed, message):
    with pytest.raises(ValueError, match=message):
        OutputErrorSettings(**changed)


def test_an_update_period_of_broken_samples_is_refused():
    assert OutputErrorSettings(update_period=0.5).samples_per_update(1000.0) == 500
    with pytest.raises(ValueError, match=r"update_period = 0.0011 s: must be a whole number of"):
        OutputErrorSettings(update_period=0.0011).samples_per_update(5000.0)


@pytest.mark.parametrize(("rate", "block"), [(5000.0, 40), (1000.0, 8), (500.0, 4), (50.0, 1)])
def test_a_block_has_the_samples_of_a_period_of_the_residual(rate, block):
    assert OutputErrorSettings().samples_per_block(rate) == block


@pytest.mark.parametrize(
    ("rate", "samples", "walking"),
    [
        (20_000.0, 4, 20),
        (10_000.0, 2, 10),
        (5000.0, 1, 5),
        (2500.0, 1, 2),
        (1999.0, 1, 1),
        (500.0, 1, 1),
    ],
)
def test_a_step_of_the_simulation_is_a_part_of_a_block(rate, samples, walking):
    settings = OutputErrorSettings()
    assert settings.samples_per_step(rate, walks=False) == samples
    assert settings.samples_per_step(rate, walks=True) == walking
    assert settings.samples_per_block(rate) % samples == 0
    assert settings.samples_per_block(rate) % walking == 0
    assert rate / samples >= min(rate, settings.simulation_rate)
    assert rate / walking >= min(rate, settings.simulation_rate / 5.0)


def test_every_sample_has_a_step_if_that_is_wanted():
    assert OutputErrorSettings(simulation_rate=1e5).samples_per_step(20_000.0, walks=True) == 1


def test_a_residual_rate_that_leaves_a_stretch_without_a_period_is_refused():
    OutputErrorSettings(residual_rate=2.0)
    with pytest.raises(ValueError, match=r"residual_rate = 1\.0 Hz: must be at least 2 Hz"):
        OutputErrorSettings(residual_rate=1.0)
