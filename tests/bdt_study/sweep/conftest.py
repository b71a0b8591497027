"""A small study, and what it gives when nothing disturbs it.

Beside a ROS 2, where rosdep has neither pyarrow nor SALib, there is no sweep to test.
"""

from importlib.util import find_spec

import pytest
import yaml

if find_spec("pyarrow") is None or find_spec("SALib") is None:
    collect_ignore_glob = ["test_*.py"]
else:
    from bdt_study.engine.part_folder import PARTS
    from bdt_study.sweep.batches import batches
    from bdt_study.sweep.data_set import DataSet
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


@pytest.fixture
def small_batches(monkeypatch):
    """Cut studies into batches of four runs."""
    monkeypatch.setattr("bdt_study.sweep.batches.MOST_RUNS", 4)


@pytest.fixture
def bytes_of():
    """Return a function that tells name and bytes of every part of a sweep's folder."""
    return lambda folder: {path.name: path.read_bytes() for path in (folder / PARTS).iterdir()}


@pytest.fixture
def undisturbed(study_file, tmp_path, bytes_of, small_batches):
    """Return the file of a study of 90 batches, and its parts from one batch after the other."""
    path = study_file(repetitions=15)
    data = DataSet(tmp_path / "undisturbed", read_study(path))
    data.create(resume=False)
    for batch in batches(read_study(path), data.missing()):
        data.write(batch.number, batch.run())
    return path, bytes_of(data.folder)
