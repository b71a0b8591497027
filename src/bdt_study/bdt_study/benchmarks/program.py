"""Benchmarks of the program ``bdt``: how soon it answers, and the pace of the loop that it runs.

It is started by its name, as a user does: ``bdt bench`` is one of its subcommands, so it is there.
"""

import json
import tempfile
from collections.abc import Sequence
from pathlib import Path
from statistics import median

from bdt_study.benchmarks.processes import output_of, time_of
from bdt_study.benchmarks.result import BenchmarkResult, BenchmarkSize, compared

PROGRAM = ("-m", "bdt_bringup.cli")
HELPS = 9
SINGLE = ["--processes", "single"]

CONTROL_RATE = 500.0
"""Control rate of the default configuration [Hz]."""


def bdt_help(_size: BenchmarkSize) -> list[BenchmarkResult]:
    """Time ``bdt --help``, which imports nothing that computes, beside Python alone."""
    # They take turns, so a busy time hits both.
    pairs = [(time_of([*PROGRAM, "--help"]), time_of(["-c", "pass"])) for _ in range(HELPS)]
    helped, bare = map(median, zip(*pairs, strict=True))
    return [compared("bdt_help", helped, "s", "Python alone", bare)]


def lockstep_real_time_factor(size: BenchmarkSize) -> list[BenchmarkResult]:
    """Run the paper's loop in processes of their own with a bag, in one process, and without."""
    separate, single, unrecorded = (
        loop_factor(size.loop_duration, options) for options in ([], SINGLE, ["--no-bag"])
    )
    name = "lockstep_real_time_factor"
    what = "all nodes in one process"
    return [
        compared(name, separate, "simulated s/s", what, single),
        compared(name, CONTROL_RATE * separate, "ticks/s", what, CONTROL_RATE * single),
        compared(
            name, CONTROL_RATE * separate, "ticks/s", "no recorder", CONTROL_RATE * unrecorded
        ),
    ]


def loop_factor(duration: float, options: Sequence[str]) -> float:
    """Return simulated seconds per second of ``bdt run``.

    Parameters
    ----------
    duration : float
        Simulated time of the loop [s].
    options : sequence of str
        Further options of the command.

    Raises
    ------
    ProcessError
        If the loop fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        output = str(Path(folder) / "run")
        command = [*PROGRAM, "run", "--json", "--duration", str(duration), "--output", output]
        return float(json.loads(output_of([*command, *options]))["real_time_factor"])
