"""The benchmarks of sweeps, without the processes that they start."""

import os

import pytest

from bdt_study.benchmarks import sweep
from bdt_study.benchmarks.bench import run_benchmarks
from bdt_study.benchmarks.result import BenchmarkSize
from bdt_study.engine.in_this_process import InThisProcess
from bdt_study.sweep.batches import batches
from bdt_study.sweep.study_file import read_study

data_set = pytest.importorskip("bdt_study.sweep.data_set", reason="beside a ROS 2 without pyarrow")

ROUNDS = 2
TINY = BenchmarkSize(sweep_runs=100 * ROUNDS, sweep_kills=3)


@pytest.fixture(autouse=True)
def _short(monkeypatch):
    monkeypatch.setattr(sweep, "DURATION", 1.0)
    monkeypatch.setattr(sweep, "ROUNDS", ROUNDS)
    monkeypatch.setattr(sweep, "KERNEL_RUNS", 3)
    monkeypatch.setattr("bdt_study.sweep.batches.MOST_RUNS", 10)


def test_rates_stand_beside_what_they_are_to_reach(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _process: {0, 1})
    monkeypatch.setattr(sweep, "LocalWorkers", lambda _count: InThisProcess())
    monkeypatch.setattr(sweep, "_dask_rate", lambda *_: (100.0, 0.0))
    results = run_benchmarks(["sweep"], TINY)["results"]
    assert [one["reference"] for one in results] == [
        "a million in 15 min",
        "kernel, all cores",
        "kernel, one core",
        "kernel",
        "pool",
        "growth of memory in 200 runs",
    ]
    assert results[0]["reference_value"] == pytest.approx(1111.1, rel=1e-3)
    assert all(one["value"] > 0 for one in results if one["unit"] != "MB")


def test_parts_that_differ_are_counted(monkeypatch):
    lives = []

    def run(study, output, life=None):
        """Write a part in each life, the last one otherwise than it should."""
        parsed = read_study(study)
        data = data_set.DataSet(output, parsed)
        data.create(resume=True)
        missing = data.missing() if life is None else data.missing()[:1]
        for batch in batches(parsed, missing):
            data.write(batch.number, batch.run())
        if life is not None:
            lives.append(life)
        if len(lives) == 3:
            next(data.parts_folder.glob("*.parquet")).write_bytes(b"otherwise")

    monkeypatch.setattr(sweep, "_run", run)
    (result,) = run_benchmarks(["sweep_kills"], TINY)["results"]
    assert len(lives) == 3
    assert (result["value"], result["reference_value"]) == (1.0, 20.0)


@pytest.mark.parametrize("name", ["sweep", "sweep_kills"])
def test_without_the_packages_of_sweeps_it_says_so(monkeypatch, name):
    monkeypatch.setattr(sweep, "find_spec", lambda package: None)
    (result,) = run_benchmarks([name], TINY)["results"]
    assert result["reference"] == "skipped: needs pyarrow and distributed"
