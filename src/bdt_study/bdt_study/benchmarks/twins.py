"""Benchmark of a fleet: how many machines this computer bears, and what comes of more of them."""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import yaml

from bdt_msgs_py.parameter_files import PARAMETERS_KEY
from bdt_study.benchmarks.processes import peer, result
from bdt_study.benchmarks.program import PROGRAM
from bdt_study.benchmarks.result import BenchmarkResult, BenchmarkSize, compared

MACHINES = "bdt_study.benchmarks.fleet_machines"
FIRST = 4
"""Machines of the first trial; each one after it has twice as many."""
MOST = 512
OVERLOAD = 1.5
WARM_UP = 10.0
BORNE_LAG = 1.0
"""Lag of a twin up to which it keeps up [s]: the time between two estimates."""
BORNE_SHARE = 0.8
"""Part of the estimates that are due, an estimate each second, above which a twin keeps up."""

TWIN = {
    "reconfigure": False,
    "estimator": {"kind": "output_error"},
    "output_error": {"update_period": 1.0},
}


@dataclass(frozen=True)
class Trial:
    """What the twins of a fleet said.

    Attributes
    ----------
    duration : float
        Time for which they were listened to [s].
    lags : sequence of float
        Largest lag of each twin [s].
    estimates : sequence of int
        Estimates of each twin.
    """

    duration: float
    lags: Sequence[float]
    estimates: Sequence[int]

    @property
    def is_borne(self) -> bool:
        """Whether all twins kept up."""
        due = BORNE_SHARE * self.duration
        return max(self.lags) <= BORNE_LAG and min(self.estimates) >= due


def twins(size: BenchmarkSize) -> list[BenchmarkResult]:
    """Find how many machines at 5 kHz `bdt twins` bears, and overload it by half as many again."""
    name = "twins"
    borne = largest_borne(lambda machines: trial(machines, size.twins_duration).is_borne)
    results = [
        BenchmarkResult(name, float(borne), "machines", "telemetry at 5 kHz, an estimate a second")
    ]
    if not borne:
        return results
    more = max(round(OVERLOAD * borne), borne + 1)
    over = trial(more, size.twins_duration)
    largest = max(*over.lags, 1e-9)
    fewest, most = min(over.estimates), max(*over.estimates, 1)
    return [
        *results,
        compared(name, median(over.lags), "s, median lag", f"largest of {more} twins", largest),
        compared(name, float(fewest), "estimates, fewest", f"most of {more} twins", float(most)),
    ]


def largest_borne(is_borne: Callable[[int], bool]) -> int:
    """Return a number of machines that is borne, to a quarter of it; 0 if no trial is.

    Parameters
    ----------
    is_borne : callable
        Tries a number of machines.
    """
    borne, over = 0, FIRST
    while over <= MOST and is_borne(over):
        borne, over = over, 2 * over
    if over > MOST:
        return borne
    while over - borne > max(borne // 4, 1):
        between = (borne + over) // 2
        if is_borne(between):
            borne = between
        else:
            over = between
    return borne


def trial(machines: int, duration: float, warm_up: float = WARM_UP) -> Trial:
    """Run a fleet beside machines that send telemetry in real time.

    Parameters
    ----------
    machines : int
        Number of machines.
    duration : float
        Time for which the twins are listened to [s].
    warm_up : float
        Time before that, in which the first estimates search from far off [s].

    Raises
    ------
    ProcessError
        If the fleet or the machines end, or have to be ended.
    """
    names = [f"machine_{number}" for number in range(machines)]
    with tempfile.TemporaryDirectory() as folder:
        configuration = Path(folder) / "fleet.yaml"
        configuration.write_text(yaml.safe_dump({"/**/twin": {PARAMETERS_KEY: TWIN}}))
        words = ["twins", *names, "--config", str(configuration)]
        with (
            peer(PROGRAM[1], words, wait=False),
            peer(MACHINES, [f"{warm_up}", f"{duration}", *names], wait=False) as sender,
        ):
            said = result(sender)
    return Trial(duration, said["lags"], said["estimates"])
