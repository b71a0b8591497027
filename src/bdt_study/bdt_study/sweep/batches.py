"""How a study is cut into batches: by what a run costs, and by nothing but the study."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from bdt_study.simulation.configured_loop import LoopParameters
from bdt_study.sweep.run_batch import Batch
from bdt_study.sweep.run_points import RunPoints
from bdt_study.sweep.study import Study

WORK_OF_A_BATCH = 2.0
"""Processor time that a batch is to take on a common core [s]: what an interruption may cost."""
MOST_RUNS = 5000
"""Most runs of a batch, so that memory stays flat."""

LOOP = 1e-4
"""Processor time for a simulated second of a piecewise linear mechanism at 5 kHz [s]."""
MACHINE = 2e-3
"""The same for one that is not linear."""
ESTIMATORS = {"none": 0.0, "inverse_filter": 2e-3, "output_error": 4e-2}
"""The same for what an estimator adds; somebody's own counts as the slowest."""
DECISION = 0.5
"""The same for decisions by simulation."""


@dataclass(frozen=True)
class BatchCut:
    """Where the batches of a study begin and end.

    Attributes
    ----------
    runs : int
        Runs of the study.
    size : int
        Runs of each batch, save the last one.
    """

    runs: int
    size: int

    @property
    def count(self) -> int:
        """Number of batches."""
        return -(-self.runs // self.size)

    def bounds(self, number: int) -> tuple[int, int]:
        """Return the first run of a batch, and the one behind its last."""
        return number * self.size, min((number + 1) * self.size, self.runs)


def cut(study: Study) -> BatchCut:
    """Return the batches of a study."""
    return BatchCut(study.runs, max(1, min(MOST_RUNS, round(WORK_OF_A_BATCH / cost_of_run(study)))))


def cost_of_run(study: Study) -> float:
    """Return about what a run of a study costs on a common core [s]."""
    parameters = LoopParameters.from_values(study.node_values())
    scenario = parameters.scenario(study.duration)
    cost = LOOP if scenario.model.is_piecewise_linear else MACHINE
    cost *= scenario.sampling.sampling_rate / 5000.0
    if study.has_twin:
        cost += ESTIMATORS.get(study.estimator, max(ESTIMATORS.values()))
        cost += DECISION if parameters.twin().decision.kind == "simulate" else 0.0
    return study.duration * cost


def batches(study: Study, numbers: Sequence[int]) -> Iterator[Batch]:
    """Iterate over some batches of a study, each made when it is asked for."""
    points, cutting = RunPoints(study), cut(study)
    for number in numbers:
        yield Batch(number, study, points.between(*cutting.bounds(number)))
