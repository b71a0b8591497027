"""Runs of a batch: the loop of the other programs, judged by other code or by hand."""

import numpy as np
import pytest

from bdt_msgs_py.command_errors import BadInputError
from bdt_plant.gap_profile import GapProfile
from bdt_study.evaluation.trial import judged_steps
from bdt_study.simulation.closed_loop import simulate
from bdt_study.sweep.run_batch import Batch, run_result
from bdt_study.sweep.run_points import RunPoints
from bdt_study.sweep.run_quantities import QUANTITIES


def all_of(study):
    return Batch(0, study, RunPoints(study).between(0, study.runs)).run().values


def test_a_run_is_the_loop_of_its_parameters(study_of):
    study = study_of()
    result = run_result(study, (0.3, 1e-4, 40.0), seed=1, run=0)
    scenario = result.scenario
    assert (scenario.gap, scenario.dead_zone) == (GapProfile("constant", 0.3), 1e-4)
    assert scenario.model.structure.damping == 40.0
    alone = simulate(scenario, ("u", "q3"))
    np.testing.assert_array_equal(result.telemetry, np.stack([alone.t, alone.u, alone.q3], axis=1))
    assert list(result.steps) == judged_steps(scenario, alone, np.zeros(scenario.control_steps))


def test_a_run_does_not_depend_on_those_before_it(study_of):
    study = study_of()
    points = RunPoints(study)
    last = Batch(0, study, points.between(47, 48)).run().values
    np.testing.assert_array_equal(all_of(study)[47:], last)


def test_quantities_are_what_their_names_say(study_of):
    study = study_of(compute=["peak_voltage_v", "energy_j", "bias_percent", "residual_m"])
    values = (0.3, 0.0, 36.9)
    result = run_result(study, values, seed=1, run=0)
    loop = simulate(result.scenario, ("u", "current", "q3"))
    found = dict(
        zip(
            study.compute,
            [QUANTITIES[name].compute(result) for name in study.compute],
            strict=True,
        )
    )
    assert found["peak_voltage_v"] == np.abs(loop.u).max()
    assert found["energy_j"] == pytest.approx(np.sum(loop.u * loop.current) / 5000.0, rel=1e-9)
    ends = loop.q3.reshape(2, 10000)[:, 5000:]
    assert found["residual_m"] == np.ptp(ends, axis=1).max()
    biases = 100.0 * np.abs(ends.mean(axis=1) - [5e-3, 0.0]) / 5e-3
    assert found["bias_percent"] == pytest.approx(biases.max(), rel=1e-9)


def test_seeds_are_of_the_noise_and_of_nothing_else(study_of):
    noisy = study_of(set={"plant.sensor.noise": 1e-6, "controller.reference.step_time": 2.0})
    quiet = all_of(study_of())
    loud = all_of(noisy)
    assert (quiet[::2] == quiet[1::2]).all()
    assert (loud[::2] != loud[1::2]).any()


def test_a_twin_estimates_and_its_reconfigurations_arrive(study_of):
    twin = {
        "estimator": "inverse_filter",
        "duration": 12.0,
        "set": {"plant.gap.kind": "constant", "plant.gap.initial": 0.2},
        "vary": {"twin.reconfigure": {"values": [True, False]}},
        "sample": None,
        "repetitions": None,
        "compute": ["estimate_rms_error_rad", "estimate_coverage"],
    }
    study = study_of(**twin)
    (told, set_too) = (run_result(study, (sets,), 1, 0) for sets in (False, True))
    assert told.tolerances.max() == 0.0
    assert set_too.tolerances.max() > 0.0
    error, coverage = all_of(study)[0]
    assert 0.0 < error < 0.05
    assert np.isnan(coverage), "the paper's estimator states no uncertainty"


MINE = """
def peak(run):
    return {}
"""


def test_a_function_of_the_users_computes_or_says_where_it_fails(study_of, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_peak.py").write_text(MINE.format("run.trajectory.q3.max()"))
    (tmp_path / "my_fault.py").write_text(MINE.format("1 / 0"))
    values = all_of(study_of(compute=["my_peak:peak"]))
    assert 5e-3 < values.min() < 0.05
    with pytest.raises(BadInputError, match=r"my_fault\.py:3: ZeroDivisionError"):
        all_of(study_of(compute=["my_fault:peak"]))
