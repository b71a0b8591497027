"""The loop in real time: from a measurement to its command, with recorder and twin running.

Driver, controller, twin and recorder run as `bdt run` starts them, around a drive that notes its
own times: each in a process of its own, or driver and controller in one. Beside it stand the same
exchange in bare bytes and a timer that does nothing else.
"""

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml

from bdt_msgs_py.parameter_files import PARAMETERS_KEY
from bdt_study.benchmarks import processes
from bdt_study.benchmarks.paced_timer import real_time_settings
from bdt_study.benchmarks.processes import output_of, peer, result
from bdt_study.benchmarks.program import PROGRAM
from bdt_study.benchmarks.result import BenchmarkResult, BenchmarkSize, compared

TIMER = "bdt_study.benchmarks.paced_timer"
BYTES = "bdt_study.benchmarks.dds_participant"
DRIVE = "bdt_study.benchmarks.timed_drive:TimedDrive"

RATES = (500.0, 1000.0)
"""Control rates [Hz]."""
LOOPS = {"separate": "the loop", "shared": "the loop, driver and controller in one process"}
"""What is measured, by the processes that `bdt run` is asked for."""
PRIORITY = 40
"""Priority of all that runs in real time: below the threads of the kernel, which have 50."""
WARM_UP = 0.5
"""Time after the first command that is left out [s]: the nodes know each other from then on."""


class Series(NamedTuple):
    """What one loop has done in time.

    Attributes
    ----------
    times : ndarray of float, shape (n,)
        How long each period's work took, or how late it was [us].
    missed : int
        Number of periods without it.
    refusals : list of str
        What the machine has refused.
    """

    times: Any
    missed: int
    refusals: list[str]

    def statistics(self) -> Iterator[tuple[str, float]]:
        """Iterate over names with unit, and values."""
        for name, percentage in (
            ("median", 50.0),
            ("p99", 99.0),
            ("p99.9", 99.9),
            ("worst", 100.0),
        ):
            yield f"us, {name}", float(np.percentile(self.times, percentage))
        yield "missed periods", float(self.missed)


def real_time(size: BenchmarkSize) -> list[BenchmarkResult]:
    """Measure the loop at each rate, as ordinary processes and with priority, beside two floors."""
    results: list[BenchmarkResult] = []
    for rate in RATES:
        for priority in (0, PRIORITY):
            timer = timer_lateness(rate, size.real_time_duration, priority)
            case = f"{rate:g} Hz, {f'priority {priority}' if priority else 'ordinary'}"
            floor = "; ".join(["timer alone", *timer.refusals])
            for shares, what in LOOPS.items():
                loop = loop_answers(rate, size.real_time_duration, priority, shares)
                results += _beside(timer, floor, loop, f"{what}, {case}")
            if find_spec("cyclonedds") is not None:
                echo = byte_echoes(rate, size.real_time_duration, priority)
                results += _beside(timer, floor, echo, f"bare bytes, {case}")
    return results


def _beside(timer: Series, floor: str, series: Series, what: str) -> Iterator[BenchmarkResult]:
    for (unit, value), (_, reference) in zip(series.statistics(), timer.statistics(), strict=True):
        text = f"{unit}: {what}"
        if reference > 0.0:
            yield compared("real_time", value, text, floor, reference)
        else:
            yield BenchmarkResult("real_time", value, text, floor, reference)


def timer_lateness(rate: float, duration: float, priority: int) -> Series:
    """Return how late a timer wakes that does nothing else."""
    words = [f"{rate}", f"{duration}", f"{priority}"]
    with peer(TIMER, words, wait=False) as timer:
        return _series(result(timer), rate, duration)


def byte_echoes(rate: float, duration: float, priority: int) -> Series:
    """Return how long bytes take to another process and back, by Cyclone DDS alone."""
    domain = str(processes.domain())
    words = ["paced", domain, f"{rate}", f"{duration}", f"{priority}"]
    with peer(BYTES, ["echo", domain, f"{priority}"]), peer(BYTES, words, wait=False) as sender:
        return _series(result(sender), rate, duration)


def loop_answers(rate: float, duration: float, priority: int, shares: str) -> Series:
    """Return how long it takes from reading the drive to its command, in a run of the nodes.

    Parameters
    ----------
    rate : float
        Control rate [Hz].
    duration : float
        How long [s].
    priority : int
        Priority of driver and controller; 0 for ordinary processes.
    shares : str
        ``separate`` or ``shared``: what `bdt run` is told of processes.
    """
    with tempfile.TemporaryDirectory() as folder:
        file, configuration = Path(folder) / "times.npy", Path(folder) / "real_time.yaml"
        configuration.write_text(yaml.safe_dump(parameters(rate, priority, file)))
        options = ["--config", str(configuration), "--duration", f"{duration + WARM_UP}"]
        options += ["--processes", shares, "--output", str(Path(folder) / "run")]
        output_of([*PROGRAM, "run", *options])
        return answered(np.load(file), rate)


def answered(times: Any, rate: float) -> Series:
    """Return the series of a drive's times [ns], of readings and of their commands.

    Parameters
    ----------
    times : ndarray of int, shape (n, 2)
        What :class:`bdt_study.benchmarks.timed_drive.TimedDrive` has noted.
    rate : float
        Control rate [Hz].
    """
    kept = times[times[:, 0] >= times[0, 0] + round(WARM_UP * 1e9)]
    periods = round(float(kept[-1, 0] - kept[0, 0]) * 1e-9 * rate) + 1
    return Series((kept[:, 1] - kept[:, 0]) * 1e-3, max(periods - len(kept), 0), [])


def parameters(rate: float, priority: int, file: Path) -> dict[str, Any]:
    """Return the parameter file of a loop around a timed drive."""
    sections = {
        "driver": {
            "driver": DRIVE,
            "drive": {"file": str(file), "control_rate": rate},
            "control_rate": rate,
            "real_time": asdict(real_time_settings(priority)),
        },
        "controller": {
            "use_sim_time": False,
            "control_rate": rate,
            "voltage_limit": 24.0,
            "reference": {"step_time": 2.0},
            "real_time": asdict(real_time_settings(priority)),
        },
        "twin": {
            "use_sim_time": False,
            "communication_delay": 0.0,
            "estimator": {"kind": "output_error", "sampling_rate": rate},
        },
    }
    return {f"/**/{node}": {PARAMETERS_KEY: values} for node, values in sections.items()}


def _series(measured: Any, rate: float, duration: float) -> Series:
    times: Sequence[int] = measured["nanoseconds"]
    missed = round(rate * duration) - len(times)
    return Series(np.array(times) * 1e-3, missed, measured["refusals"])
