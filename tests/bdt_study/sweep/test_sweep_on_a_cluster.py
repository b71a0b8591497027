"""A sweep on a real Dask scheduler with workers as processes, on loopback."""

import json
import subprocess
import sys
import time

import pytest

from bdt_bringup.cli import run_command
from bdt_msgs_py.command_errors import BAD_INPUT, LoopError
from bdt_study.sweep.batches import batches
from bdt_study.sweep.data_set import DataSet
from bdt_study.sweep.study_file import read_study

dask_cluster = pytest.importorskip("bdt_study.engine.dask_cluster")

DEADLINE = 120.0
SERVE = ["--host", "127.0.0.1", "--port", "0"]


@pytest.fixture
def cluster(tmp_path):
    """Return the scheduler's address, its process, and a function that starts a worker."""
    file = tmp_path / "scheduler.json"
    processes = []

    def start(kind, *arguments):
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *arguments]
        with (tmp_path / f"{kind}-{len(processes)}.log").open("wb") as log:
            processes.append(subprocess.Popen(command, stdout=log, stderr=log, cwd=tmp_path))
        return processes[-1]

    scheduler = start("scheduler", *SERVE, "--no-dashboard", "--scheduler-file", str(file))
    end = time.monotonic() + DEADLINE
    while not file.exists() or not file.read_text():
        assert time.monotonic() < end
        assert scheduler.poll() is None
        time.sleep(0.02)
    address = json.loads(file.read_text())["address"]
    here = ["--host", "127.0.0.1", "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    yield address, scheduler, lambda: start("worker", address, *here)
    for process in processes:
        process.kill()
        process.wait(DEADLINE)


def test_killed_workers_and_a_lost_scheduler_cost_no_bytes(
    cluster, undisturbed, bytes_of, tmp_path, capsys, monkeypatch
):
    # A busy computer may take its time; that of a scheduler that is gone is waited for in vain.
    monkeypatch.setattr(dask_cluster, "PATIENCE", DEADLINE)
    address, scheduler, start_worker = cluster
    path, expected = undisturbed
    study = read_study(path)
    data = DataSet(tmp_path / "sweep", study)
    data.create(resume=False)
    first = start_worker()

    def disturb(written):
        if written == 5:
            start_worker()
            first.kill()
        if written == 40:
            scheduler.kill()

    def work(engine):
        results = engine.results(batches(study, data.missing()))
        for written, (number, result) in enumerate(results, start=1):
            data.write(number, result)
            disturb(written)

    with (
        dask_cluster.DaskCluster(address) as engine,
        pytest.raises(LoopError, match=f"^the scheduler {address} is gone$"),
    ):
        work(engine)
    assert 40 <= len(list(data.parts_folder.iterdir())) < len(expected)
    assert bytes_of(data.folder).items() <= expected.items()

    monkeypatch.setattr(dask_cluster, "PATIENCE", 1.0)
    arguments = ["sweep", str(path), "--output", str(data.folder), "--resume"]
    assert run_command([*arguments, "--scheduler", address]) == BAD_INPUT
    told = capsys.readouterr().err
    assert told == f"error: --scheduler {address}: no scheduler answers there\n"
