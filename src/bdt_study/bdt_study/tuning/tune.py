"""From a mechanism and its ranges to a recommendation, with the evidence for it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from bdt_controller.pid import PidGains
from bdt_plant.plant import PlantModel
from bdt_study.engine.job import Engine
from bdt_study.tuning.candidate_outcome import Candidate, summarize
from bdt_study.tuning.linear_judgment import LinearJudgment, judge
from bdt_study.tuning.loop_trial import LoopOutcome, Tried, run_loops
from bdt_study.tuning.mechanism_ranges import MechanismRanges, corners
from bdt_study.tuning.robust_design import ControllerDesign, RobustSearch
from bdt_study.tuning.targets import Targets
from bdt_twin.dead_zone_tolerance import DeadZoneSettings

INTEGRAL_TIMES = (1.0, 2.0, 3.0, 5.0)
"""Integral times that are tried, as multiples of 1 / bandwidth."""
RATIOS = (0.8, 0.6, 0.5, 0.4)
"""Narrower dead zones that are tried with the gains that were chosen, over that of eq. 9."""
MARGIN = 0.0174533
"""Margin of the dead zone [rad]: that of laboratory.yaml, 1 degree."""
SCREENING = 100_000
"""Number of the first loop by which candidates are chosen: others than those that confirm."""

CONTENDERS = 3
"""Most candidates that are put to the confirmation."""

Progress = Callable[[str, int, int], object]


@dataclass(frozen=True)
class Tuning:
    """What was tried and what is recommended.

    Attributes
    ----------
    nominal : PlantModel
        The mechanism as it is believed to be.
    ranges : MechanismRanges
        How far it may be off.
    targets : Targets
        What was asked for.
    control_rate : float
        Rate of measurements [Hz].
    baseline : Candidate
        The gains so far on the mechanism as it is believed to be: the measure of settling.
    screened : tuple of Candidate
        All that were tried.
    before, recommended : Candidate
        The gains so far and those that are recommended, in loops that had no part in the choice.
    """

    nominal: PlantModel
    ranges: MechanismRanges
    targets: Targets
    control_rate: float
    baseline: Candidate
    screened: tuple[Candidate, ...]
    before: Candidate
    recommended: Candidate

    @property
    def is_met(self) -> bool:
        """Whether what is recommended meets the targets."""
        return not self.lacks(self.recommended)

    def lacks(self, candidate: Candidate) -> list[str]:
        """Return the targets that a candidate does not meet."""
        return self.targets.lacks(candidate, self.baseline)


class Tuner:
    """Tries controllers on a mechanism within ranges.

    Parameters
    ----------
    engine : Engine
        What works on the random loops.
    nominal : PlantModel
        The mechanism as it is believed to be.
    ranges : MechanismRanges
        How far it may be off.
    gains : PidGains
        Gains so far.
    targets : Targets
        What is asked for.
    control_rate : float
        Rate of measurements [Hz].
    progress : callable
        Called with what is being done, how much is done and how much there is.
    """

    def __init__(
        self,
        engine: Engine,
        nominal: PlantModel,
        ranges: MechanismRanges,
        gains: PidGains,
        targets: Targets,
        control_rate: float,
        progress: Progress,
    ) -> None:
        self._engine = engine
        self._models = corners(nominal, ranges)
        self._nominal, self._ranges, self._targets = nominal, ranges, targets
        self._today = Tried(ControllerDesign("as it is", gains), DeadZoneSettings(margin=MARGIN))
        self._rate, self._progress = control_rate, progress
        self._judged: dict[ControllerDesign, LinearJudgment] = {}

    def tune(self, screening: int, loops: int, seed: int) -> Tuning:
        """Return the recommendation.

        Parameters
        ----------
        screening : int
            Random loops by which candidates are chosen.
        loops : int
            Random loops in which the chosen one is confirmed.
        seed : int
            Number of the first of these.
        """
        seeds = range(SCREENING + seed, SCREENING + seed + screening)
        search = RobustSearch(self._models, self._targets.bandwidth, self._rate)
        (baseline,) = self._try([self._today], seeds, self._models[:1], "as it is, nominal")
        tried = [self._today]
        for number, multiple in enumerate(INTEGRAL_TIMES):
            self._progress("PID designs", number, len(INTEGRAL_TIMES))
            tried.append(self._designed(search, multiple, with_notch=False))
        screened = self._try(tried, seeds, self._models, "PID candidates")
        if all(self._targets.lacks(one, baseline) for one in screened):
            # No PID of the paper's form does it: one filter in series is offered.
            notched = [self._designed(search, one, with_notch=True) for one in INTEGRAL_TIMES[::2]]
            screened += self._try(notched, seeds, self._models, "with a filter in series")
        best = self._ranked(screened, baseline)[0]
        narrower = [
            Tried(best.tried.design, DeadZoneSettings(ratio=ratio, margin=MARGIN))
            for ratio in RATIOS
        ]
        screened += self._try(narrower, seeds, self._models, "narrower dead zones")
        confirming = range(seed, seed + loops)
        (measure,) = self._try([self._today], confirming, self._models[:1], "as it is, nominal")
        # What few loops have chosen has been lucky: many others have to confirm it.
        contenders = self._ranked(screened, baseline)[:CONTENDERS]
        before, recommended = self._confirm(contenders[0], confirming)
        for contender in contenders[1:]:
            if not self._targets.lacks(recommended, measure):
                break
            _, confirmed = self._confirm(contender, confirming)
            recommended = self._ranked([recommended, confirmed], measure)[0]
        return Tuning(
            self._nominal,
            self._ranges,
            self._targets,
            self._rate,
            measure,
            tuple(screened),
            before,
            recommended,
        )

    def _confirm(self, contender: Candidate, seeds: Sequence[int]) -> list[Candidate]:
        """Return the gains so far and a contender in loops that had no part in the choice."""
        return self._try([self._today, contender.tried], seeds, self._models, "confirmation")

    def _designed(self, search: RobustSearch, multiple: float, *, with_notch: bool) -> Tried:
        time = multiple / self._targets.bandwidth
        name = f"{'notch, ' if with_notch else ''}T_i = {time:g} s"
        design = search.design(name, time, with_notch=with_notch)
        return Tried(design, DeadZoneSettings(margin=MARGIN))

    def _ranked(self, candidates: Sequence[Candidate], baseline: Candidate) -> list[Candidate]:
        """Return candidates, those that lack least first, of these the one with least bias."""

        def rank(candidate: Candidate) -> tuple[int, float, float]:
            lacking = len(self._targets.lacks(candidate, baseline))
            worth = candidate.bias if not lacking else -candidate.success
            return lacking, worth, candidate.settling

        return sorted(candidates, key=rank)

    def _try(
        self,
        tried: Sequence[Tried],
        seeds: Sequence[int],
        models: Sequence[PlantModel],
        what: str,
    ) -> list[Candidate]:
        outcomes: list[list[LoopOutcome]] = []
        for outcome in run_loops(self._engine, models, tried, seeds, self._rate):
            outcomes.append(outcome)
            self._progress(what, len(outcomes), len(seeds))
        return [
            summarize(one, self._linear(one.design), [loop[place] for loop in outcomes])
            for place, one in enumerate(tried)
        ]

    def _linear(self, design: ControllerDesign) -> LinearJudgment:
        if design not in self._judged:
            self._judged[design] = judge(design, self._models, self._rate)
        return self._judged[design]
