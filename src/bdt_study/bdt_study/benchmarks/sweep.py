"""Benchmarks of sweeps: runs in a second, cores, memory, Dask, and the bytes after many kills."""

import os
import random
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import NamedTuple

import yaml

from bdt_study.benchmarks.result import BenchmarkResult, BenchmarkSize, compared
from bdt_study.engine.job import Engine
from bdt_study.engine.local_workers import LocalWorkers
from bdt_study.simulation.closed_loop import (
    discrete_loop,
    initial_state,
    sample_inputs,
    signals_for,
)
from bdt_study.simulation.configured_loop import LoopParameters
from bdt_study.simulation.loop_kernel import run_kernel
from bdt_study.sweep.batches import batches
from bdt_study.sweep.study import Study
from bdt_study.sweep.study_file import read_study

DURATION = 20.0
"""Simulated time of a run [s]."""
MILLION = 1e6
ENOUGH = 900.0
"""Time in which a million runs are to be done [s]."""
GAPS = 10
DEAD_ZONES = 10
LONGEST_LIFE = 8.0
"""Longest time from the start of the command to its kill [s]."""
KERNEL_RUNS = 200
"""Runs of the kernel alone on each core."""
QUIET_WORKERS = {
    "distributed.worker.profile.enabled": False,
    "distributed.worker.memory.monitor-interval": "1s",
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
}
"""Settings with which Dask's workers do not look at themselves up to a hundred times a second."""
ROUNDS = 4
"""How often all are measured in turn: the speed of a computer changes within minutes."""


class _Round(NamedTuple):
    """Runs in a second, measured one after the other, and the growth of memory [MB]."""

    kernel: float
    kernel_on_all: float
    one: float
    many: float
    dask: float
    grown: float


def sweep(size: BenchmarkSize) -> list[BenchmarkResult]:
    """Time runs of 20 s without a twin, from the study to the parts on the disk.

    Values are medians of the rounds, and so are ratios.
    """
    name, unit = "sweep", "runs/s"
    if lacks := _lacking():
        return [BenchmarkResult(name, 0.0, unit, f"skipped: needs {lacks}")]
    cores = len(os.sched_getaffinity(0))
    with _folder(size.sweep_runs * cores // ROUNDS) as folder:
        study = read_study(folder / "study.yaml")
        rounds = [_round(study, folder / str(number), cores) for number in range(ROUNDS)]

    def beside(
        unit: str,
        value: Callable[[_Round], float],
        reference: str,
        its_value: Callable[[_Round], float],
    ) -> BenchmarkResult:
        found, its = median(map(value, rounds)), median(map(its_value, rounds))
        ratio = median(value(one) / its_value(one) for one in rounds)
        return BenchmarkResult(name, found, unit, reference, its, ratio)

    grown = median(one.grown for one in rounds)
    return [
        beside(unit, lambda one: one.many, "a million in 15 min", lambda _: MILLION / ENOUGH),
        beside(unit, lambda one: one.many, "kernel, all cores", lambda one: one.kernel_on_all),
        beside(
            f"{unit}, one worker", lambda one: one.one, "kernel, one core", lambda one: one.kernel
        ),
        beside(
            "times with all cores",
            lambda one: one.many / one.one,
            "kernel",
            lambda one: one.kernel_on_all / one.kernel,
        ),
        beside(f"{unit}, Dask", lambda one: one.dask, "pool", lambda one: one.many),
        BenchmarkResult(name, grown, "MB", f"growth of memory in {study.runs} runs"),
    ]


def _round(study: Study, folder: Path, cores: int) -> _Round:
    one, grown = _rate(study, folder / "one", LocalWorkers(1), 1)
    many, _ = _rate(study, folder / "many", LocalWorkers(cores), cores)
    dask, _ = _dask_rate(study, folder / "dask", cores)
    return _Round(_kernel_rate(study, 1), _kernel_rate(study, cores), one, many, dask, grown)


def sweep_kills(size: BenchmarkSize) -> list[BenchmarkResult]:
    """Kill the command again and again at random moments and compare the bytes in the end."""
    if lacks := _lacking():
        return [BenchmarkResult("sweep_kills", 0.0, "", f"skipped: needs {lacks}")]
    draws = random.Random(20_261_122)  # noqa: S311
    with _folder(size.sweep_runs) as folder:
        study = folder / "study.yaml"
        _run(study, folder / "whole")
        for _ in range(size.sweep_kills):
            _run(study, folder / "killed", life=draws.uniform(0.0, LONGEST_LIFE))
        _run(study, folder / "killed")
        whole, killed = (_bytes_of(folder / name) for name in ("whole", "killed"))
    wrong = sum(killed.get(name) != content for name, content in whole.items())
    wrong += len(killed.keys() - whole.keys())
    what = f"parts, after {size.sweep_kills} kills"
    return [compared("sweep_kills", float(wrong), "parts that differ", what, float(len(whole)))]


@contextmanager
def _folder(runs: int) -> Iterator[Path]:
    """Give a folder with a study of so many runs in it."""
    document = {
        "duration": DURATION,
        "estimator": "none",
        "set": {"plant.gap.kind": "constant"},
        "vary": {
            "plant.gap.initial": {"from": 0.02, "to": 0.5, "count": GAPS},
            "controller.dead_zone_tolerance": {"from": 0.0, "to": 1e-4, "count": DEAD_ZONES},
        },
        "repetitions": max(runs // (GAPS * DEAD_ZONES), 1),
        "compute": ["limit_cycle", "bias_percent", "settling_s"],
    }
    with TemporaryDirectory() as name:
        path = Path(name) / "study.yaml"
        path.write_text(yaml.safe_dump(document, sort_keys=False), encoding="utf-8")
        yield Path(name)


def _rate(study: Study, folder: Path, engine: Engine, workers: int) -> tuple[float, float]:
    """Return runs in a second and growth of memory [MB], once each worker has given a part.

    What comes before is the start: of the workers, and of pyarrow in this process. Workers give
    their parts at nearly the same time, so to count from the first one of all would be too good.
    """
    # Only sweeps need pyarrow.
    from bdt_study.sweep.data_set import DataSet  # noqa: PLC0415

    data = DataSet(folder, study)
    data.create(resume=False)
    began = before = 0.0
    runs = 0
    with engine:
        results = engine.results(batches(study, data.missing()))
        for written, (number, result) in enumerate(results, start=1):
            data.write(number, result)
            if written == workers:
                began, before = time.perf_counter(), _peak_memory()
            elif began:
                runs += len(result.values)
        rate = runs / (time.perf_counter() - began) if runs else 0.0
    return rate, _peak_memory() - before


def _dask_rate(study: Study, folder: Path, cores: int) -> tuple[float, float]:
    # Only sweeps on a cluster need Dask.
    from distributed import LocalCluster  # noqa: PLC0415

    from bdt_study.engine.dask_cluster import DaskCluster  # noqa: PLC0415

    cluster = LocalCluster(
        n_workers=cores,
        threads_per_worker=1,
        host="127.0.0.1",
        dashboard_address=None,
        config=QUIET_WORKERS,
    )
    with cluster:
        return _rate(study, folder, DaskCluster(cluster.scheduler_address), cores)


def _kernel_rate(study: Study, cores: int) -> float:
    """Return runs in a second of the kernel alone."""
    scenario = LoopParameters.from_values(study.node_values()).scenario(DURATION)
    inputs, step = sample_inputs(scenario), discrete_loop(scenario)

    def run(times: int) -> None:
        signals = signals_for(scenario, ("u", "q3"))
        for _ in range(times):
            run_kernel(initial_state(scenario, inputs), step, inputs, signals)

    run(1)
    began = time.perf_counter()
    # The kernel holds no lock of Python's.
    with ThreadPoolExecutor(cores) as threads:
        list(threads.map(run, [KERNEL_RUNS] * cores))
    return cores * KERNEL_RUNS / (time.perf_counter() - began)


def _run(study: Path, output: Path, life: float | None = None) -> None:
    """Run the command, to its end or to that of its life [s]."""
    command = [sys.executable, "-m", "bdt_bringup.cli", "sweep", str(study)]
    command += ["--output", str(output), "--resume"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # noqa: S603
    try:
        process.wait(life)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _bytes_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.rglob("*.parquet")}


def _lacking() -> str:
    """Return the packages of the extra `sweep` that are not there."""
    return " and ".join(name for name in ("pyarrow", "distributed") if find_spec(name) is None)


def _peak_memory() -> float:
    """Return the largest memory of this process so far [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
