"""What happens to a job on a worker; a whole sweep on a cluster is in the tests of sweeps."""

from importlib.metadata import version

import pytest
from quick_jobs import Square

from bdt_msgs_py.command_errors import BadInputError

dask_cluster = pytest.importorskip("bdt_study.engine.dask_cluster")


def test_a_worker_with_another_version_refuses():
    here = version("bdt_study")
    assert dask_cluster.run_on_worker(Square(3), here) == 9
    with pytest.raises(BadInputError, match=rf"a worker has bdt_study {here}, .* has 0\.0\.1"):
        dask_cluster.run_on_worker(Square(3), "0.0.1")
