"""The trials of an evaluation as jobs: cases, twins and seeds, numbered."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from importlib.metadata import version
from typing import NamedTuple

from bdt_study.evaluation.case import Case
from bdt_study.evaluation.trial import Trial, run_trial
from bdt_twin.decision_settings import KINDS as DECISIONS


class Twin(NamedTuple):
    """A twin that is tried.

    Attributes
    ----------
    kind : str
        Its estimator.
    decision : str
        How it decides on dead zone and gains; empty for what a case has.
    """

    kind: str
    decision: str = ""

    def in_case(self, case: Case) -> "Twin":
        """Return the twin as it is tried in a case."""
        return Twin(self.kind, self.decision or case.decision)

    @property
    def label(self) -> str:
        """Name in figures: the estimator, and how it decides if it is told so, and not eq. 9."""
        is_usual = self.decision in ("", DECISIONS[0])
        return self.kind if is_usual else f"{self.kind}, {self.decision}"


class FinishedTrial(NamedTuple):
    """A trial and what was tried.

    Attributes
    ----------
    case : str
        Name of the case.
    twin : Twin
        The twin.
    seed : int
        Number of the scenario.
    trial : Trial
        What it gave.
    """

    case: str
    twin: Twin
    seed: int
    trial: Trial


@dataclass(frozen=True)
class TrialJob:
    """A trial that is to be run.

    Attributes
    ----------
    number : int
        Its number in the evaluation.
    case : Case
        The conditions.
    twin : Twin
        The twin.
    seed : int
        Number of the scenario.
    """

    number: int
    case: Case
    twin: Twin
    seed: int

    @property
    def name(self) -> str:
        """What it is, in a few words."""
        return f"{self.case.name} with {self.twin.label}, seed {self.seed}"

    def run(self) -> FinishedTrial:
        """Run the loop.

        Raises
        ------
        BadInputError
            If an estimator of the user's fails.
        """
        trial = run_trial(self.case, self.twin.kind, self.seed, self.twin.decision)
        return FinishedTrial(self.case.name, self.twin, self.seed, trial)


@dataclass(frozen=True)
class Evaluation:
    """All trials: each case with each twin, for each seed.

    Attributes
    ----------
    cases : tuple of Case
        Conditions.
    twins : tuple of Twin
        Estimators and decisions.
    first_seed : int
        Number of the first scenario; the same ones for every case and twin.
    scenarios : int
        Number of scenarios.
    """

    cases: tuple[Case, ...]
    twins: tuple[Twin, ...]
    first_seed: int
    scenarios: int

    @property
    def seeds(self) -> range:
        """Numbers of the scenarios."""
        return range(self.first_seed, self.first_seed + self.scenarios)

    @property
    def trials(self) -> int:
        """Number of trials."""
        return self.scenarios * len(self.cases) * len(self.twins)

    @property
    def text(self) -> str:
        """All that a trial's number and outcome follow from, as JSON.

        The number of scenarios is no part of it: more of them only add trials.
        """
        document = {
            "cases": [asdict(case) for case in self.cases],
            "estimators": [twin.kind for twin in self.twins],
            "decisions": [twin.decision for twin in self.twins],
            "seed": self.first_seed,
            "version": version("bdt_study"),
        }
        return json.dumps(document, sort_keys=True)

    def jobs(self, numbers: Iterable[int]) -> Iterator[TrialJob]:
        """Iterate over the trials with these numbers, scenario by scenario."""
        for number in numbers:
            which, twin = divmod(number, len(self.twins))
            scenario, case = divmod(which, len(self.cases))
            chosen = self.cases[case]
            yield TrialJob(number, chosen, self.twins[twin].in_case(chosen), self.seeds[scenario])
