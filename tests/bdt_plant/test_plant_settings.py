"""Settings of the plant node: defaults and refusals."""

import pytest

from bdt_plant.plant_settings import PlantSettings


def test_the_plant_runs_in_lockstep_without_end_and_without_followers():
    settings = PlantSettings()
    assert settings.mode == "lockstep"
    assert settings.duration == 0.0
    assert not any(settings.lockstep_followers)


@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
def test_both_modes_are_accepted(mode):
    assert PlantSettings(mode=mode).mode == mode


@pytest.mark.parametrize(
    ("fault", "text"),
    [
        ({"mode": "fast"}, r"mode = 'fast': must be one of lockstep, realtime"),
        ({"duration": -1.0}, r"duration = -1\.0 s: must be 0 to 1e\+09 s"),
        ({"telemetry_period": 0.0}, r"telemetry_period = 0\.0 s: must be 0\.0001 to 1000 s"),
        ({"clock_rate": 0.0}, r"clock_rate = 0\.0 Hz: must be 0\.1 to 100000 Hz"),
        ({"command_timeout": float("nan")}, r"command_timeout = nan s: must be 0\.001 to 1000 s"),
        ({"lockstep_timeout": float("inf")}, r"lockstep_timeout = inf s: must be 0\.1 to 1e\+06 s"),
        ({"resend_period": "0.2"}, r"resend_period = '0\.2': must be a number, 0\.001 to 1000 s"),
        ({"lockstep_followers": "twin"}, r"lockstep_followers = 'twin': must be a list"),
        ({"lockstep_followers": ("twin", 3)}, r"lockstep_followers\[1\] = 3: must be a text"),
    ],
)
def test_a_fault_is_named_with_its_value_and_what_is_allowed(fault, text):
    with pytest.raises(ValueError, match=r"^PlantSettings\." + text):
        PlantSettings(**fault)
