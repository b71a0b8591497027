"""The command ``bdt evaluate``: estimators on random scenarios, as a table, JSON and a figure."""

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import NamedTuple

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.output_files import PICTURES, not_writable, prepare_output
from bdt_plant.plant import PlantModel
from bdt_study.evaluation.case import Case
from bdt_study.evaluation.cases import CASES
from bdt_study.evaluation.outcome import CaseOutcome, summarize_trials
from bdt_study.evaluation.trial import Trial, run_trial
from bdt_study.simulation.worker_pool import WorkerPool
from bdt_twin.decision_settings import KINDS as DECISIONS
from bdt_twin.estimator_choice import KINDS, EstimatorChoice, create_estimator
from bdt_twin.inverse_filter import InverseFilterSettings
from bdt_twin.output_error_settings import OutputErrorSettings

SEEDS = 2**31
"""Number of scenarios: each has the seed of a sensor."""


def evaluate(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    cases = [_case(name) for name in options.cases] if options.cases else list(CASES)
    kinds = [_kind(kind) for kind in options.estimator or KINDS]
    if not (options.runs >= 1 and options.seed >= 0 and options.seed + options.runs <= SEEDS):
        raise BadInputError(
            f"--runs {options.runs} --seed {options.seed}: must be at least 1 and at least 0, "
            f"together at most {SEEDS}"
        )
    if options.figure is not None:
        prepare_output("--figure", options.figure, PICTURES)
    seeds = range(options.seed, options.seed + options.runs)
    twins = [Twin(kind, how) for kind in kinds for how in options.decision or DECISIONS[:1]]
    trials = run_trials(cases, twins, seeds)
    outcomes = [
        summarize_trials(case.name, twin.kind, trials[case.name, twin.label], twin.decision)
        for case in cases
        for twin in twins
    ]
    if options.figure is not None:
        # Nothing else here needs the plotting library.
        from bdt_study.evaluation.figure import error_figure  # noqa: PLC0415

        try:
            error_figure(trials).savefig(options.figure)
        except OSError as error:
            raise not_writable("--figure", options.figure, error) from error
    if options.json:
        print(json.dumps({"cases": [asdict(outcome) for outcome in outcomes]}, indent=2))
    else:
        Console().print(outcome_table(outcomes))
    return 0


class Twin(NamedTuple):
    """A twin that is tried.

    Attributes
    ----------
    kind : str
        Its estimator.
    decision : str
        How it decides on dead zone and gains.
    """

    kind: str
    decision: str

    @property
    def label(self) -> str:
        """Name in figures: the estimator, and how it decides if that is not eq. 9."""
        return self.kind if self.decision == DECISIONS[0] else f"{self.kind}, {self.decision}"


def run_trials(
    cases: Sequence[Case], twins: Sequence[Twin], seeds: Sequence[int]
) -> dict[tuple[str, str], list[Trial]]:
    """Run all trials on all cores, with a progress bar on standard error.

    Parameters
    ----------
    cases : sequence of Case
        Conditions.
    twins : sequence of Twin
        Estimators and decisions.
    seeds : sequence of int
        Numbers of the scenarios, the same ones for every case and estimator.

    Returns
    -------
    dict
        Trials in the order of the seeds, for each (name of the case, label of the twin).
    """
    jobs = [(case, twin, seed) for seed in seeds for case in cases for twin in twins]
    results = dict(_finished(jobs))
    return {
        (case.name, twin.label): [results[case.name, twin, seed] for seed in seeds]
        for case in cases
        for twin in twins
    }


def _finished(
    jobs: list[tuple[Case, Twin, int]],
) -> Iterator[tuple[tuple[str, Twin, int], Trial]]:
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    progress = Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True))
    with progress:
        task = progress.add_task("closed-loop runs", total=len(jobs))
        for (case, twin, seed), trial in WorkerPool(_trial).results(iter(jobs)):
            yield (case.name, twin, seed), trial
            progress.advance(task)


def _trial(job: tuple[Case, Twin, int]) -> Trial:
    case, twin, seed = job
    return run_trial(case, twin.kind, seed, twin.decision)


def outcome_table(outcomes: Sequence[CaseOutcome]) -> Table:
    """Return the outcomes as a table for the terminal."""
    table = Table(title=f"gap estimates in closed loop, {outcomes[0].runs} random runs each")
    table.add_column("case", no_wrap=True)
    table.add_column("estimator", no_wrap=True)
    table.add_column("decision", no_wrap=True)
    for name in (
        "rms error [deg]",
        "worst [deg]",
        "95 % covers [%]",
        "x CRB",
        "no limit cycle [%]",
        "avoidable [%]",
        "bias < 2 % [%]",
        "bias [%]",
        "settling [s]",
        "window [ms]",
    ):
        table.add_column(name, justify="right")
    for row in outcomes:
        table.add_row(
            row.case,
            row.estimator,
            row.decision,
            _text(row.rms_error_deg, ".2g"),
            _text(row.worst_error_deg, ".2g"),
            _text(row.coverage_95, ".0f"),
            _text(row.crb_ratio, ".1f"),
            _text(row.limit_cycle_free_percent, ".0f"),
            _text(row.avoidable_limit_cycle_percent, ".0f"),
            _text(row.bias_under_2_percent, ".0f"),
            _text(row.worst_bias_percent, ".2f"),
            _text(row.settling_s, ".1f"),
            _text(row.window_ms, ".0f"),
        )
    return table


def _text(value: float | None, form: str) -> str:
    return "-" if value is None else f"{value:{form}}"


def _case(name: str) -> Case:
    for case in CASES:
        if case.name == name:
            return case
    raise BadInputError(f"case {name!r}: must be one of {', '.join(case.name for case in CASES)}")


def _kind(kind: str) -> str:
    """Return the estimator's name if there is such an estimator."""
    try:
        create_estimator(
            EstimatorChoice(kind), PlantModel(), InverseFilterSettings(), OutputErrorSettings()
        )
    except ValueError as error:
        raise BadInputError(str(error)) from error
    return kind
