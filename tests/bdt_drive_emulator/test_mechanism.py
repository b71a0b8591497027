"""The mechanism is the plant of a configuration."""

from pathlib import Path

import pytest

from bdt_drive_emulator.mechanism import load_mechanism
from bdt_msgs_py.command_errors import BadInputError

CONFIG = Path(__file__).parents[2] / "config"


def test_it_is_that_of_the_configuration():
    mechanism = load_mechanism(CONFIG / "workshop.yaml", 1000.0)
    assert mechanism.model.motor.resistance == 12.96
    assert mechanism.actuator.limit == 24.0
    assert mechanism.sampling.samples_per_control_step == 5


def test_without_a_file_it_is_the_paper_s():
    assert load_mechanism(None, 500.0).sensor.is_ideal


FAULTS = [
    ("/**/twin:\n  ros__parameters:\n    reconfigure: true\n", "holds nothing for /plant"),
    ("/**/plant:\n  motor: {}\n", "must hold the key ros__parameters, only"),
    ("/**/plant:\n  ros__parameters:\n    motor: {inductence: 1.0}\n", "did you mean"),
    ("/**/plant:\n  ros__parameters:\n    sampling_rate: 5500.0\n", "must divide sampling_rate"),
]


@pytest.mark.parametrize(("text", "line"), FAULTS)
def test_what_is_wrong_with_a_file_is_one_line(tmp_path, text, line):
    file = tmp_path / "machine.yaml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(BadInputError, match=line):
        load_mechanism(file, 1000.0)
