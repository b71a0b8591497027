"""What is known of the gap while windows teach nothing: the last answer, or a rough one."""

import math

from bdt_twin.estimator import Estimate

ROUGHEST = 5.0
"""Largest uncertainties up to which a gap is worth knowing as long as nothing better is."""
SAME_REVERSAL = 0.1
"""Time between two reversals from which on they are not the same one, found anew [s]."""
SURER = 1.5
"""Uncertainty of an answer over that of the next one that takes its place at the same reversal."""
SHARE_OF_DIFFERENCE = 0.5
"""Share of the difference of two answers at the same reversal by which it is less sure."""


class GapKnowledge:
    """Keeps the last answer, and a gap that was too unsure for one where that is surer by now.

    A loop whose dead zone is missing, or much too narrow, needs no answer to be better off: five
    degrees and their uncertainty are a bound.

    Parameters
    ----------
    largest_uncertainty : float
        Standard uncertainty above which a gap is no answer [rad].
    """

    def __init__(self, largest_uncertainty: float) -> None:
        self._largest = largest_uncertainty
        self._answer: Estimate | None = None
        self._rough: Estimate | None = None

    def learn(self, answer: Estimate) -> Estimate:
        """Take an answer and return what is to be stated.

        An answer at the reversal of the one before lacks data that this one had, and takes its
        place only where it is surer nevertheless. Where they differ, the gap depends on data
        besides this reversal's, and both are less sure.
        """
        known = self._answer
        if known is not None and answer.time - known.time < SAME_REVERSAL:
            surer = answer if SURER * answer.uncertainty < known.uncertainty else known
            doubt = SHARE_OF_DIFFERENCE * (answer.gap - known.gap)
            answer = answer._replace(
                time=surer.time,
                gap=surer.gap,
                uncertainty=math.hypot(surer.uncertainty, doubt),
                growth=surer.growth,
                growth_uncertainty=surer.growth_uncertainty,
                age=answer.age + answer.time - surer.time,
            )
        self._answer, self._rough = answer, None
        return answer

    def learn_roughly(self, estimate: Estimate, growth_change: float) -> None:
        """Take a gap that is no answer, if it is surer than what is known.

        Parameters
        ----------
        estimate : Estimate
            The gap. It is thought to be no surer than an answer may be: nothing has confirmed it.
        growth_change : float
            Scale of the growth rate's change in one second [rad/s^1.5]; so in what follows.
        """
        rough = estimate._replace(uncertainty=max(estimate.uncertainty, self._largest))
        now = rough.time + rough.age
        if rough.uncertainty > ROUGHEST * self._largest:
            return
        if _held(rough, now, growth_change) < self._surest(now, growth_change)[1]:
            if self._answer is not None:
                rough = rough._replace(
                    voltage_offset=self._answer.voltage_offset,
                    voltage_offset_uncertainty=self._answer.voltage_offset_uncertainty,
                )
            self._rough = rough

    def expected(self, time: float, growth_change: float) -> tuple[float, float] | None:
        """Return gap and uncertainty [rad] at a time [s] as the last answer tells them."""
        if self._answer is None:
            return None
        answer = self._answer
        age = time - answer.time
        return answer.gap + answer.growth * age, _grown(answer, age, growth_change)

    def held(self, time: float, reason: str, growth_change: float) -> Estimate:
        """Return what is known, as unsure as it is for a window that has taught nothing.

        Parameters
        ----------
        time : float
            Stamp of the window's newest sample [s].
        reason : str
            Why it has taught nothing.
        growth_change : float
            See :meth:`learn_roughly`.
        """
        known, uncertainty = self._surest(time, growth_change)
        if known is None:
            return Estimate(time, math.nan, math.inf, reason=reason)
        return known._replace(uncertainty=uncertainty, reason=reason, age=time - known.time)

    def _surest(self, time: float, growth_change: float) -> tuple[Estimate | None, float]:
        """Return what is surest at a time, with its uncertainty then [rad]."""
        known = [each for each in (self._answer, self._rough) if each is not None]
        if not known:
            return None, math.inf
        pairs = [(each, _held(each, time, growth_change)) for each in known]
        return min(pairs, key=lambda pair: pair[1])


def _grown(known: Estimate, age: float, growth_change: float) -> float:
    """Return how unsure an estimate is of the gap some time [s] later, if it grows on."""
    change = growth_change * age * math.sqrt(max(age, 0.0) / 3)
    return math.hypot(known.uncertainty, age * known.growth_uncertainty, change)


def _held(known: Estimate, time: float, growth_change: float) -> float:
    """Return how unsure an estimate is at a time [s] as a gap that does not grow."""
    age = time - known.time
    return math.hypot(_grown(known, age, growth_change), age * known.growth)
