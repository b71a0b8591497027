"""What a study computes of each run: quantities by name, ours and anybody's."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_tables import suggestion
from bdt_msgs_py.user_code import UserCode
from bdt_study.sweep.run_result import RunResult
from bdt_twin import fixed_order

COVERAGE = 1.96
"""Standard uncertainties within which 95 % of the errors are to lie."""

Compute = Callable[[RunResult], float]


@dataclass(frozen=True)
class RunQuantity:
    """A quantity of a run.

    Attributes
    ----------
    name : str
        Its column; ends with its unit.
    description : str
        One line for the schema and the reference.
    compute : callable
        Returns its value; what is not a number is unknown.
    needs_twin : bool
        Whether there must be a twin in the loop.
    signals : tuple of str
        Signals of the loop that it looks at, besides u and q3.
    """

    name: str
    description: str
    compute: Compute
    needs_twin: bool = False
    signals: tuple[str, ...] = ()


def _limit_cycle(run: RunResult) -> float:
    known = [step.limit_cycle for step in run.steps if step.limit_cycle is not None]
    return float(any(known)) if known else math.nan


def _limit_cycle_amplitude(run: RunResult) -> float:
    return _largest(step.limit_cycle_amplitude_m for step in run.steps)


def _bias(run: RunResult) -> float:
    biases = (step.bias_percent_of_amplitude for step in run.steps)
    return _largest(None if bias is None else abs(bias) for bias in biases)


def _residual(run: RunResult) -> float:
    return _largest(step.residual_peak_to_peak_m for step in run.steps)


def _settling(run: RunResult) -> float:
    """Return the longest settling time; unknown if a step does not settle."""
    if any(step.settling_time_s is None for step in run.steps):
        return math.nan
    return _largest(step.settling_time_s for step in run.steps)


def _peak_voltage(run: RunResult) -> float:
    voltage = run.telemetry[:, 1]
    return float(max(voltage.max(), -voltage.min()))


def _energy(run: RunResult) -> float:
    energy = fixed_order.dot(run.telemetry[:, 1], run.trajectory.current)
    return energy / run.scenario.sampling.sampling_rate


def _rms_error(run: RunResult) -> float:
    errors = run.errors
    if not errors.size:
        return math.nan
    return math.sqrt(fixed_order.dot(errors, errors) / errors.size)


def _coverage(run: RunResult) -> float:
    stated = np.array([estimate.uncertainty for estimate in run.learned])
    known = np.isfinite(stated)
    if not known.any():
        return math.nan
    return int((np.abs(run.errors[known]) <= COVERAGE * stated[known]).sum()) / int(known.sum())


def _largest(values: Iterable[float | None]) -> float:
    return max((value for value in values if value is not None), default=math.nan)


QUANTITIES = {
    quantity.name: quantity
    for quantity in (
        RunQuantity(
            "limit_cycle", "1 if a judged step ends in a limit cycle, 0 if none", _limit_cycle
        ),
        RunQuantity(
            "limit_cycle_amplitude_m",
            "largest amplitude of a limit cycle; empty without one",
            _limit_cycle_amplitude,
        ),
        RunQuantity("bias_percent", "largest bias of a step, of its height", _bias),
        RunQuantity("residual_m", "largest peak to peak of q3 at the end of a step", _residual),
        RunQuantity(
            "settling_s", "longest settling time; empty if a step does not settle", _settling
        ),
        RunQuantity("peak_voltage_v", "largest voltage of either sign", _peak_voltage),
        RunQuantity(
            "energy_j", "electrical energy that the motor took", _energy, signals=("current",)
        ),
        RunQuantity(
            "estimate_rms_error_rad",
            "rms of estimated less true gap, of the estimates that rest on something",
            _rms_error,
            needs_twin=True,
        ),
        RunQuantity(
            "estimate_coverage",
            "share of these estimates whose 95 % interval covers the true gap",
            _coverage,
            needs_twin=True,
        ),
    )
}
"""Quantities by name."""


@lru_cache(maxsize=64)
def quantity_of(name: str) -> RunQuantity:
    """Return a quantity.

    Parameters
    ----------
    name : str
        One of ``QUANTITIES``, or ``module:name`` of a function that takes a
        :class:`~bdt_study.sweep.run_result.RunResult` and returns a number. The module may lie in
        the current folder.

    Raises
    ------
    BadInputError
        If there is none.
    """
    if name in QUANTITIES:
        return QUANTITIES[name]
    module, _, function = name.partition(":")
    if not (module and function):
        raise BadInputError(
            f"compute: {name!r}: must be one of {', '.join(QUANTITIES)} or module:name"
            f"{suggestion(name, QUANTITIES)}"
        )
    code = UserCode(name, BadInputError)
    return RunQuantity(name, f"function {function} of {module}", _guarded(code), signals=ALL)


ALL = ("current", "omega_m", "theta_m", "d", "q1", "q2", "measured", "r")
"""Signals that a function of the user's may look at."""


def _guarded(code: UserCode) -> Compute:
    def compute(run: RunResult) -> float:
        with code.errors_in_one_line():
            return float(code.factory(run))

    return compute
