"""The command ``bdt evaluate``: estimators on random scenarios, as a table, JSON and a figure."""

import argparse
import json
from collections.abc import Iterable
from dataclasses import asdict

from rich.console import Console

from bdt_msgs_py.command_errors import INTERRUPTED, BadInputError, complain
from bdt_msgs_py.output_files import PICTURES, not_writable, prepare_output
from bdt_plant.plant import PlantModel
from bdt_study.engine.chosen_engine import chosen_engine
from bdt_study.engine.job import Engine
from bdt_study.engine.job_progress import JobProgress
from bdt_study.engine.optional_packages import DATA_SETS, check_imports
from bdt_study.evaluation.case import Case
from bdt_study.evaluation.cases import CASES
from bdt_study.evaluation.outcome import summarize_trials
from bdt_study.evaluation.outcome_table import outcome_tables
from bdt_study.evaluation.trial_job import Evaluation, FinishedTrial, Twin
from bdt_twin.estimator_choice import KINDS, EstimatorChoice, create_estimator
from bdt_twin.inverse_filter import InverseFilterSettings
from bdt_twin.output_error_settings import OutputErrorSettings

SEEDS = 2**31
"""Number of scenarios: each has the seed of a sensor."""


def evaluate(options: argparse.Namespace) -> int:
    """Run the command and return its exit code.

    Raises
    ------
    BadInputError
        For options or a folder that are not as they must be.
    LoopError
        If workers or the scheduler are lost.
    """
    evaluation = _evaluation(options)
    if options.output is not None:
        check_imports("--output", DATA_SETS)
    elif options.resume:
        raise BadInputError("--resume: needs --output, the folder to go on with")
    if options.figure is not None:
        prepare_output("--figure", options.figure, PICTURES)
    with chosen_engine(options.workers, options.scheduler) as engine:
        if options.output is None:
            finished = _finished(evaluation, engine)
        else:
            # Only who keeps trials needs pyarrow.
            from bdt_study.evaluation.trial_folder import keep_trials  # noqa: PLC0415

            finished = keep_trials(evaluation, engine, options.output, resume=options.resume)
    if len(finished) < evaluation.trials:
        return complain(
            f"interrupted: {len(finished)} of {evaluation.trials} runs are in {options.output}; "
            "to go on: the same command with --resume",
            INTERRUPTED,
        )
    _tell(evaluation, finished, options)
    return 0


def _finished(evaluation: Evaluation, engine: Engine) -> list[FinishedTrial]:
    """Run all trials and keep them nowhere."""
    finished = []
    with JobProgress("closed-loop runs", evaluation.trials) as progress:
        for _, trial in engine.results(evaluation.jobs(range(evaluation.trials))):
            finished.append(trial)
            progress.add(1)
    return finished


def _tell(
    evaluation: Evaluation, finished: Iterable[FinishedTrial], options: argparse.Namespace
) -> None:
    """Print the table or JSON and draw the figure."""
    results = {(one.case, one.twin, one.seed): one.trial for one in finished}
    trials = {
        (case, twin): [results[case.name, twin.in_case(case), seed] for seed in evaluation.seeds]
        for case in evaluation.cases
        for twin in evaluation.twins
    }
    outcomes = [
        summarize_trials(case.name, twin.kind, runs, twin.in_case(case).decision)
        for (case, twin), runs in trials.items()
    ]
    if options.figure is not None:
        # Nothing else here needs the plotting library.
        from bdt_study.evaluation.figure import error_figure  # noqa: PLC0415

        labelled = {(case.name, twin.label): runs for (case, twin), runs in trials.items()}
        try:
            error_figure(labelled).savefig(options.figure)
        except OSError as error:
            raise not_writable("--figure", options.figure, error) from error
    if options.json:
        print(json.dumps({"cases": [asdict(outcome) for outcome in outcomes]}, indent=2))
    else:
        Console().print(*outcome_tables(outcomes))


def _evaluation(options: argparse.Namespace) -> Evaluation:
    """Return what is asked for."""
    cases = [_case(name) for name in options.cases] if options.cases else CASES
    if not (options.runs >= 1 and options.seed >= 0 and options.seed + options.runs <= SEEDS):
        raise BadInputError(
            f"--runs {options.runs} --seed {options.seed}: must be at least 1 and at least 0, "
            f"together at most {SEEDS}"
        )
    kinds = [_kind(kind) for kind in options.estimator or KINDS]
    twins = [Twin(kind, how) for kind in kinds for how in options.decision or [""]]
    return Evaluation(tuple(cases), tuple(twins), options.seed, options.runs)


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
