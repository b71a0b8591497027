"""What a benchmark is asked, what it answers, and whether that meets its target."""

import operator
from collections.abc import Iterable
from dataclasses import dataclass

from bdt_msgs_py.command_errors import BadInputError

MEETS = {"at most": operator.le, "at least": operator.ge}
"""Kinds of targets."""


@dataclass(frozen=True)
class BenchmarkSize:
    """How much is computed.

    Attributes
    ----------
    duration : float
        Simulated time of the scenario [s].
    python_control_duration : float
        Simulated time that python-control is given [s]; its time is scaled to `duration`.
    repeats : int
        Number of runs behind each median.
    batch : int
        Number of scenarios of a batch for each core.
    messages : int
        Number of messages of a transport benchmark.
    loop_duration : float
        Simulated time of the loop of the nodes [s].
    real_time_duration : float
        Time of each loop in real time [s].
    sweep_runs : int
        Number of runs of a sweep, for each core where workers are timed.
    sweep_kills : int
        Number of times that a sweep is killed.
    twins_duration : float
        Time for which the twins of each fleet are listened to [s].
    """

    duration: float = 120.0
    python_control_duration: float = 1.0
    repeats: int = 21
    batch: int = 16
    messages: int = 10000
    loop_duration: float = 20.0
    real_time_duration: float = 10.0
    sweep_runs: int = 20_000
    sweep_kills: int = 50
    twins_duration: float = 15.0


@dataclass(frozen=True)
class BenchmarkResult:
    """One number beside its reference.

    Attributes
    ----------
    name : str
        Name of the benchmark.
    value : float
        What was measured.
    unit : str
        Unit of `value` and `reference_value`.
    reference : str
        What it is compared with, or why not.
    reference_value : float or None
        What was measured of the reference in the same run; None if there is none.
    ratio : float or None
        `value` divided by `reference_value`.
    target : str
        ``at most`` or ``at least`` where `reference_value` is what `value` has to be; else empty.
    """

    name: str
    value: float
    unit: str
    reference: str
    reference_value: float | None = None
    ratio: float | None = None
    target: str = ""


def compared(
    name: str, value: float, unit: str, reference: str, reference_value: float
) -> BenchmarkResult:
    """Return a result with its ratio."""
    ratio = value / reference_value
    return BenchmarkResult(name, value, unit, reference, reference_value, ratio)


def missed_targets(results: Iterable[BenchmarkResult]) -> list[str]:
    """Return a line for each target that is missed; what is not a number misses it.

    Raises
    ------
    BadInputError
        If none of the results has a target.
    """
    judged = [(each, each.reference_value) for each in results if each.target]
    if not judged:
        raise BadInputError("--check: none of these benchmarks has a target")
    return [
        f"{each.name}: {each.value:.4g} {each.unit}: must be {each.target} {limit:.4g}"
        for each, limit in judged
        if limit is not None and not MEETS[each.target](each.value, limit)
    ]
