"""A sweep on a real Dask scheduler with workers as processes, on loopback."""

import pytest

from bdt_bringup.cli import run_command
from bdt_msgs_py.command_errors import BAD_INPUT, LoopError
from bdt_study.sweep.batches import batches
from bdt_study.sweep.data_set import DataSet
from bdt_study.sweep.study_file import read_study

dask_cluster = pytest.importorskip("bdt_study.engine.dask_cluster")

DEADLINE = 120.0


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
