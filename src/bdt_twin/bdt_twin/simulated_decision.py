"""Dead zone and gains chosen by simulation instead of eq. 9."""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_controller.control_law import ControlLaw, discretize_control
from bdt_plant.plant import PlantModel
from bdt_twin.dead_zone_tolerance import tolerance_for_gap
from bdt_twin.decision import ControllerGains, Decision
from bdt_twin.decision_loop import Member
from bdt_twin.decision_settings import DecisionSettings
from bdt_twin.estimator import Estimate
from bdt_twin.loop_watch import LoopWatch
from bdt_twin.machine_knowledge import MachineKnowledge
from bdt_twin.mechanism_ensemble import MechanismEnsemble
from bdt_twin.simulated_outcome import SimulatedOutcome, StepTrials

FloatArray = NDArray[np.float64]

NARROWER = (1.0, 0.8, 0.7, 0.6)
"""Dead zones that are tried as long as they do, over that of eq. 9.

None below 0.6: what it spares in bias is not worth what nobody knows of a mechanism.
"""
WIDER = (1.25, 1.6, 2.0)
"""Those that are tried if eq. 9 itself fails."""
SIMULATED = 48.0
"""Time that is simulated with each mechanism and dead zone [s]."""
SHORTEST, LONGEST = 4.0, 12.0
"""Lengths between which simulated steps are [s], whatever the last ones were."""
BETTER = 0.9
"""Share of dead zone or settling time so far that other gains have to need at most to be taken."""
SMALL_BIAS = 0.002
"""Bias up to which biases are alike, as a share of a step's height."""


class _Choice(NamedTuple):
    ratio: float
    outcome: SimulatedOutcome


class SimulatedDecision:
    """Decides, and watches whether what it expected comes true.

    Parameters
    ----------
    settings : DecisionSettings
        How.
    model : PlantModel
        The mechanism, as the twin knows it.
    gains : ControllerGains
        What the controller has.
    redesign : ControllerGains or None
        What it may be set to; None to leave its gains alone.
    horizon : float
        Time for which a decision is to hold at least [s].
    """

    def __init__(
        self,
        settings: DecisionSettings,
        model: PlantModel,
        gains: ControllerGains,
        redesign: ControllerGains | None,
        horizon: float = 0.0,
    ) -> None:
        self._settings, self._horizon = settings, horizon
        self._pitch = model.lead_screw.pitch
        self._first, self._redesign = gains, redesign
        self._ensemble = MechanismEnsemble(
            model, settings.members, settings.control_rate, settings.seed
        )
        self.restart()

    def restart(self) -> None:
        """Forget what was decided: another run begins."""
        self._gains = self._first
        self._may_redesign = self._redesign is not None
        self._watch = LoopWatch(self._settings.patience, min(self._settings.step_heights))
        self._before: float | None = None
        self._simulated: tuple[float, _Choice | None, str] | None = None
        self._distrusted_until = -math.inf
        self._taken_back = 0
        self._why = ""
        self._trials = self._next_steps()

    def resume(self, gains: Mapping[str, float]) -> None:
        """Go on with the redesign, if these are its gains by the controller's names."""
        if self._redesign is not None and dict(self._redesign.by_name()) == dict(gains):
            self._gains, self._may_redesign = self._redesign, False

    def watch(self, rows: FloatArray) -> None:
        """Look whether the loop comes to rest as was expected.

        Parameters
        ----------
        rows : ndarray, shape (n, 3)
            Telemetry rows (t [s], u [V], q3 [m]).
        """
        worse = self._watch.take(rows)
        if worse and not self._is_on_probation(float(rows[-1, 0])):
            self._taken_back += 1
            self._distrusted_until = float(rows[-1, 0]) + self._settings.probation
            self._gains, self._may_redesign = self._first, False
            self._why = worse

    def decide(
        self,
        estimate: Estimate,
        machine: MachineKnowledge | None,
        now: float,
        delay: float,
        noise: float = 0.0,
    ) -> Decision:
        """Return dead zone and gains for an estimate.

        Parameters
        ----------
        estimate : Estimate
            What is known of the gap, which must be.
        machine : MachineKnowledge or None
            What is known of the machine; None for the model alone.
        now : float
            Time of the decision [s].
        delay : float
            Time that it takes to the controller [s].
        noise : float
            Standard deviation of the noise of a reading [m].
        """
        between = 0.0 if self._before is None else max(now - self._before, 0.0)
        self._before = now
        soonest = now + delay
        latest = soonest + max(between, self._horizon)
        width = tolerance_for_gap(
            estimate.gap + max(estimate.growth, 0.0) * max(latest - estimate.time, 0.0), self._pitch
        )
        if self._is_on_probation(now):
            self._simulated = None
            self._watch.expect(math.inf, width)
            reason = f"eq. 9, as a decision was taken back: {self._why}"
            return self._decision(width, None, reason)._replace(distrust=self._why)
        if self._simulated is not None and now - self._simulated[0] < self._settings.period:
            return self._decision(width, *self._simulated[1:])
        members = self._ensemble.draw(estimate, machine, soonest, latest, noise)
        self._trials = self._next_steps()
        chosen = self._narrowest(members, self._gains, width)
        other = self._better(members, chosen, width)
        if other is not None:
            chosen, self._may_redesign = other, False
        if chosen is None:
            self._watch.expect(math.inf, width)
            reason = (
                f"eq. 9: steps end in limit cycles with dead zones up to {WIDER[-1]:g} times it"
            )
        else:
            self._watch.expect(chosen.outcome.longest, width)
            names = "redesigned gains" if self._gains != self._first else "the controller's gains"
            reason = (
                f"narrowest without a limit cycle in {len(members)} mechanisms with {names}, "
                f"{chosen.ratio:g} times eq. 9"
            )
        self._simulated = now, chosen, reason
        return self._decision(width, chosen, reason)

    def _decision(self, width: float, chosen: _Choice | None, reason: str) -> Decision:
        # Sent with each dead zone, so that whatever was lost or taken back comes right.
        gains = self._gains if self._redesign is not None else None
        if chosen is None:
            return Decision(None, gains, reason, taken_back=self._taken_back)
        ratio, outcome = chosen
        return Decision(
            ratio * width,
            gains,
            reason,
            ratio,
            outcome.bias,
            outcome.settling,
            self._taken_back,
        )

    def _next_steps(self) -> StepTrials:
        """Return trials of steps like the last ones, or like those of the settings."""
        settings = self._settings
        heights = tuple(self._watch.heights) or settings.step_heights
        length = min(max(self._watch.step_time or settings.step_time, SHORTEST), LONGEST)
        pairs = max(round(SIMULATED / (2.0 * length)), 1)
        # However long the steps are, the same time is simulated: work is bounded.
        chosen = [heights[number % len(heights)] for number in range(pairs)]
        return StepTrials(chosen, length, settings.control_rate, settings.voltage_limit)

    def _is_on_probation(self, now: float) -> bool:
        return now < self._distrusted_until

    def _better(
        self, members: list[Member], so_far: _Choice | None, width: float
    ) -> _Choice | None:
        """Take the redesign if it is better on the same mechanisms; return its dead zone."""
        if not self._may_redesign or self._redesign is None:
            return None
        found = self._narrowest(members, self._redesign, width)
        if found is None:
            return None
        if so_far is not None:
            now, then = so_far.outcome, found.outcome
            is_worse = (
                found.ratio > so_far.ratio
                or then.settling > now.settling
                or then.bias > max(now.bias, SMALL_BIAS)
            )
            is_better = (
                found.ratio <= BETTER * so_far.ratio or then.settling <= BETTER * now.settling
            )
            if is_worse or not is_better:
                return None
        self._gains = self._redesign
        return found

    def _narrowest(
        self, members: list[Member], gains: ControllerGains, width: float
    ) -> _Choice | None:
        """Return the narrowest dead zone next to that of eq. 9 that does; None if none does."""
        law = self._law(gains)
        found: _Choice | None = None
        for ratio in NARROWER:
            outcome = self._trials.outcome(members, law, ratio * width)
            if outcome.failed:
                break
            found = _Choice(ratio, outcome)
        if found is not None:
            return found
        for ratio in WIDER:
            outcome = self._trials.outcome(members, law, ratio * width)
            if not outcome.failed:
                return _Choice(ratio, outcome)
        return None

    def _law(self, gains: ControllerGains) -> ControlLaw:
        return discretize_control(gains.pid, 1.0 / self._settings.control_rate, gains.notch)
