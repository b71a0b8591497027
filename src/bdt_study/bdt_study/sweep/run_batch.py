"""Runs of a study, one batch of them after the other: what a worker does, wherever it is."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.command_errors import BadInputError
from bdt_study.simulation.closed_loop import (
    SIGNALS,
    Scenario,
    discrete_loop,
    initial_state,
    sample_inputs,
    signals_for,
    trajectory_of,
)
from bdt_study.simulation.configured_loop import LoopParameters, simulate_setup
from bdt_study.simulation.loop_kernel import SIMULATED, run_kernel
from bdt_study.sweep.axis import Axis
from bdt_study.sweep.run_quantities import RunQuantity, quantity_of
from bdt_study.sweep.run_result import RunResult
from bdt_study.sweep.study import Study

FloatArray = NDArray[np.float64]

U, Q3 = SIMULATED.index("u"), SIMULATED.index("q3")


class Points(NamedTuple):
    """Some runs that follow each other.

    Attributes
    ----------
    first : int
        Number of the first run.
    repetitions : list of int
        Which repetition of its point each run is.
    seeds : list of int
        Seeds of noise and link.
    columns : tuple of list
        For each axis of the study the values.
    """

    first: int
    repetitions: list[int]
    seeds: list[int]
    columns: tuple[list[Any], ...]


@dataclass(frozen=True, eq=False)
class BatchResult:
    """What the runs of a batch gave.

    Attributes
    ----------
    points : Points
        The runs.
    values : ndarray, shape (runs, quantities)
        What was computed; NaN for what is unknown.
    """

    points: Points
    values: FloatArray


@dataclass(frozen=True)
class Batch:
    """Runs that are worked on together and become a part of the data set together.

    Attributes
    ----------
    number : int
        Number of the part.
    study : Study
        The study.
    points : Points
        The runs.
    """

    number: int
    study: Study
    points: Points

    @property
    def name(self) -> str:
        """What it is, in a few words."""
        return f"part {self.number}"

    def run(self) -> BatchResult:
        """Run the loops.

        Raises
        ------
        BadInputError
            If the values of a run do not go together, or a function of the user's fails.
        """
        prepared = _prepared(self.study)
        rows = [prepared.values_of(*run) for run in _runs(self.points)]
        return BatchResult(self.points, np.array(rows, dtype=np.float64))


def run_result(study: Study, values: Sequence[Any], seed: int, run: int) -> RunResult:
    """Return one run with its signals, which hold until the next one is asked for."""
    return _prepared(study).result_of(run, seed, values)


class _PreparedStudy:
    """All that the runs of a study share in a process: parameters, quantities, memory."""

    def __init__(self, study: Study) -> None:
        self._study = study
        self._parameters = LoopParameters.from_values(study.node_values())
        self._quantities: tuple[RunQuantity, ...] = tuple(map(quantity_of, study.compute))
        looked_at = {name for one in self._quantities for name in one.signals}
        self._keep = tuple(name for name in SIGNALS if name in looked_at | {"u", "q3"})
        self._buffers = _Buffers()

    def values_of(self, run: int, seed: int, values: Sequence[Any]) -> list[float]:
        """Return what is computed of a run."""
        result = self.result_of(run, seed, values)
        return [quantity.compute(result) for quantity in self._quantities]

    def result_of(self, run: int, seed: int, values: Sequence[Any]) -> RunResult:
        """Return a run."""
        study = self._study
        try:
            parameters = self._parameters.with_values(changes_of(study.axes, values))
            scenario = parameters.scenario(study.duration, seed)
            return (
                self._with_twin(parameters, scenario, seed)
                if study.has_twin
                else (self._alone(scenario))
            )
        except BadInputError:
            raise
        except ValueError as error:
            raise BadInputError(f"run {run}: {error}") from error

    def _alone(self, scenario: Scenario) -> RunResult:
        inputs = sample_inputs(scenario)
        signals, telemetry = self._buffers.of(scenario, self._keep)
        run_kernel(initial_state(scenario, inputs), discrete_loop(scenario), inputs, signals)
        loop = trajectory_of(scenario, inputs, signals, self._keep)
        return RunResult(scenario, telemetry, loop, inputs.tolerances)

    def _with_twin(self, parameters: LoopParameters, scenario: Scenario, seed: int) -> RunResult:
        twin = parameters.twin(seed)
        run = simulate_setup(scenario, twin, self._keep)
        loop = run.loop
        # What the paper's estimator states is a mean over its window (figure 6).
        is_mean = twin.estimator.kind == "inverse_filter"
        return RunResult(
            scenario,
            np.stack([loop.t, loop.u, loop.q3], axis=1),
            loop,
            run.tolerances,
            run.estimates,
            0.5 * twin.inverse_filter.window if is_mean else 0.0,
        )


class _Buffers:
    """Memory of the signals, the same for one run after the other: new memory takes longer."""

    def __init__(self) -> None:
        self._form = (0, 0.0)
        self._signals: tuple[FloatArray, ...] = ()
        self._telemetry = np.empty((0, 3))

    def of(
        self, scenario: Scenario, keep: Sequence[str]
    ) -> tuple[tuple[FloatArray, ...], FloatArray]:
        """Return the signals for the kernel, and the telemetry whose columns two of them are."""
        samples, rate = form = (scenario.samples, scenario.sampling.sampling_rate)
        if form != self._form:
            self._form = form
            # Columns that lie in one piece: the kernel writes two of them.
            self._telemetry = np.empty((samples, 3), order="F")
            self._telemetry[:, 0] = np.arange(samples) / rate
            signals = list(signals_for(scenario, keep))
            signals[U], signals[Q3] = self._telemetry[:, 1], self._telemetry[:, 2]
            self._signals = tuple(signals)
        return self._signals, self._telemetry


def changes_of(axes: Sequence[Axis], values: Sequence[Any]) -> dict[tuple[str, str], Any]:
    """Return the values of a run by node and flat name of the parameter."""
    changes = {}
    for axis, value in zip(axes, values, strict=True):
        for name in axis.names:
            node, _, flat = name.partition(".")
            changes[node, flat] = value
    return changes


def _runs(points: Points) -> Iterator[tuple[int, int, tuple[Any, ...]]]:
    """Iterate over number, seed and values of each run."""
    rows = zip(*points.columns, strict=True) if points.columns else [()] * len(points.seeds)
    for place, (seed, values) in enumerate(zip(points.seeds, rows, strict=True)):
        yield points.first + place, seed, values


@lru_cache(maxsize=2)
def _prepared(study: Study) -> _PreparedStudy:
    return _PreparedStudy(study)
