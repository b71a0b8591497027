"""A small study, and what it gives when nothing disturbs it."""

import pytest
import yaml

from bdt_study.sweep.study_file import read_study

SMALL = {
    "duration": 4.0,
    "estimator": "none",
    "set": {"plant.gap.kind": "constant", "controller.reference.step_time": 2.0},
    "vary": {
        "plant.gap.initial": {"from": 0.02, "to": 0.5, "count": 3},
        "controller.dead_zone_tolerance": {"values": [0.0, 1e-4]},
        "plant.structure.damping": {
            "uniform": [30.0, 44.0],
            "also": ["twin.structure.damping"],
        },
    },
    "sample": {"method": "sobol", "count": 4},
    "repetitions": 2,
    "compute": ["limit_cycle", "bias_percent", "peak_voltage_v"],
}
"""48 runs of 4 s on a grid of 3 x 2 cells with 4 samples and 2 repetitions in each."""


@pytest.fixture
def study_file(tmp_path):
    """Return a function that writes a study with some keys changed; None takes a key away."""

    def write(name="small", **changes):
        document = {key: value for key, value in (SMALL | changes).items() if value is not None}
        path = tmp_path / f"{name}.yaml"
        path.write_text(yaml.safe_dump(document, sort_keys=False))
        return path

    return write


@pytest.fixture
def study_of(study_file):
    """Return a function that reads a study with some keys changed."""
    return lambda **changes: read_study(study_file(**changes))
