"""A Dask scheduler with workers as processes, on loopback."""

import json
import subprocess
import sys
import time

import pytest

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
