"""What one window after the other tells about a machine: which effects it has, and how large."""

import math
from collections import deque
from collections.abc import Collection
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.motor import MotorParameters
from bdt_twin.amplifier_offset import VoltageOffset, told_offset
from bdt_twin.cogging_search import CoggingEvidence
from bdt_twin.effect_trials import TRIED, EffectTrial, TrialTimes, of_present
from bdt_twin.innovations import NoiseLevels
from bdt_twin.machine_knowledge import (
    COGGING,
    EFFECTS,
    FRICTION_CHANGES,
    YIELD_ANGLE,
    MachineKnowledge,
    first_knowledge,
)
from bdt_twin.machine_recollection import MachineRecollection
from bdt_twin.model_factors import FACTORS
from bdt_twin.noise_levels import is_restless

FloatArray = NDArray[np.float64]

EVIDENCE = 4.0
"""Gain of log-likelihood by an effect that is evidence of it."""
WITH_FRICTION = ("voltage_offset", "excess_voltage", "stribeck_speed", "load_voltage")
"""Effects of every motor with friction: friction differs by direction and by speed, and the screw
has some, too. To leave them out until there is evidence would make the first windows too sure."""
OF_FRICTION = frozenset(map(EFFECTS.index, FRICTION_CHANGES))
"""Places in ``EFFECTS`` of changes of the friction, which only a motor with friction has: cogging
looks like such a change, too."""
SMALLEST_FRICTION, FRICTION_COVERAGE = 0.02, 5.0
"""Voltage [V] and standard uncertainties from which on a motor has friction for certain: cogging
looks like a little friction, too."""
COGGING_EVIDENCE = 8.0
"""Gain of log-likelihood that is evidence of cogging: many numbers of periods are tried."""
OTHER_EVIDENCE = 4.0
"""Gain of log-likelihood by another number of periods than the known one for which it is tried."""
SEARCH_EVERY, SEARCH_AGAIN = 2, 6
"""Windows from one search for cogging to the next, and from one that has found nothing better."""
PLAUSIBLE = 4.0
"""Standard deviations of what is known of any machine within which one is."""


class _Told(NamedTuple):
    """What a window has told: when it ended [s], what, and what the machine was thought to have."""

    time: float
    machine: MachineKnowledge
    present: frozenset[int]
    cogs: int


class MachineMemory:
    """Remembers what windows have told until a window begins that has no data in common with them.

    A machine has no effect until a window gives evidence of it; from then on it has.

    Parameters
    ----------
    motor : MotorParameters
        The motor, as the twin knows it.

    Attributes
    ----------
    cogs : int
        Periods of the motor's cogging in a turn; 0 as long as there is no evidence of any.
    """

    def __init__(self, motor: MotorParameters) -> None:
        self._motor = motor
        self._told: deque[_Told] = deque()
        self._known: _Told | None = None
        self._present = set[int]()
        self.cogs, self._unsearched = 0, SEARCH_EVERY
        self._has_offset, self._trials = False, TrialTimes()
        self._recalled: tuple[MachineKnowledge, float] | None = None
        if motor.coulomb_friction > 0.0:
            self._present.add(EFFECTS.index("friction_voltage"))

    @property
    def present(self) -> frozenset[int]:
        """Places in ``EFFECTS`` of those that the machine has."""
        return frozenset(self._present)

    def begin_anew(self, cogs: int, present: Collection[int]) -> None:
        """Forget what windows have told of a machine that is another one.

        Parameters
        ----------
        cogs : int
            Periods of its motor's cogging in a turn.
        present : collection of int
            Places in ``EFFECTS`` of what it has besides.
        """
        self._told.clear()
        self._known = self._recalled = None
        self.cogs, self._present = cogs, {*COGGING, *present}

    def with_yield_angle(self, angle: float) -> "MachineMemory":
        """Return the memory of a machine like this, of which windows have not told anything.

        What they have told is wrong if they thought its friction another one.

        Parameters
        ----------
        angle : float
            Angle by which its friction is expected to yield [rad]; 0 for rigid friction.
        """
        other, known = MachineMemory(self._motor), first_knowledge(self._motor)
        other.cogs, other._present = self.cogs, self._present - {YIELD_ANGLE}
        if angle > 0.0:
            other._present |= {YIELD_ANGLE}
        other._has_offset = self._has_offset
        known.expected[len(FACTORS) + YIELD_ANGLE] = angle
        other._recalled = known, 0.0
        return other

    def be_like(self, other: "MachineMemory") -> None:
        """Take over what another memory knows to be present, but for whether friction yields.

        Parameters
        ----------
        other : MachineMemory
            The other one.
        """
        yields = self._present & {YIELD_ANGLE}
        self.cogs, self._present = other.cogs, (other._present - {YIELD_ANGLE}) | yields
        self._has_offset = other._has_offset

    def recollection(self) -> MachineRecollection | None:
        """Return what is worth keeping; None before the first window has told anything."""
        newest = self._told[-1] if self._told else self._known
        if newest is None:
            return None
        present = frozenset(EFFECTS[effect] for effect in newest.present)
        return MachineRecollection(newest.machine, present, self.cogs, self._has_offset)

    def recall(self, kept: MachineRecollection, age: float) -> None:
        """Begin with what was kept of the same machine.

        Parameters
        ----------
        kept : MachineRecollection
            What was kept.
        age : float
            Time since then [s], to the first window.
        """
        self._present |= {EFFECTS.index(name) for name in kept.present}
        self.cogs, self._has_offset = kept.cogs, kept.has_offset
        self._recalled = kept.machine, age

    def before(self, time: float, newest: float) -> MachineKnowledge:
        """Return what is known of a window from those before it.

        Parameters
        ----------
        time, newest : float
            Times of its first and of its newest sample [s]; the windows before ended by the first.
        """
        while self._told and self._told[0].time < time:
            self._known = self._told.popleft()
        if self._known is None and self._recalled is not None:
            machine, age = self._recalled
            self._known = _Told(time - age, machine, self.present, self.cogs)
        known = first_knowledge(self._motor)
        if self._known is not None:
            aged = self._known.machine.aged(time - self._known.time)
            aged = aged.projected(newest - self._known.time)
            new = self._present - self._known.present
            if self._known.cogs != self.cogs:
                new |= COGGING
            known = aged.bounded(known).forgetting(new)
        return of_present(known, self._present)

    def learn(self, time: float, machine: MachineKnowledge) -> None:
        """Remember what a window has told that ended at a time [s]."""
        self._told.append(_Told(time, machine, self.present, self.cogs))

    def has_evidence(self, evidence: FloatArray, machine: MachineKnowledge) -> bool:
        """Take the absent effect with most evidence for present; tell whether there is one.

        Parameters
        ----------
        machine : MachineKnowledge
            What the window has told: effects of a motor with friction join with certain friction.
        evidence : ndarray, shape (effects,)
            Gain of log-likelihood by each of ``EFFECTS``.
        """
        has_friction = self.has_friction(machine)
        others = {EFFECTS.index(name) for name in WITH_FRICTION} - self._present
        if others and has_friction:
            self._present |= others
            return True
        gains = evidence.copy()
        gains[list(self._present if has_friction else self._present | OF_FRICTION)] = 0.0
        if float(gains.max()) <= EVIDENCE:
            return False
        self._present.add(int(gains.argmax()))
        return True

    def has_friction(self, machine: MachineKnowledge, least: float = SMALLEST_FRICTION) -> bool:
        """Tell whether a window has told that the motor has friction for certain.

        Parameters
        ----------
        machine : MachineKnowledge
            What it has told.
        least : float
            Voltage from which on it is friction [V].
        """
        friction = EFFECTS.index("friction_voltage")
        place = len(FACTORS) + friction
        surely = FRICTION_COVERAGE * math.sqrt(float(machine.covariance[place, place]))
        found = float(machine.expected[place])
        return friction in self._present and found > max(surely, least)

    def to_try(self, levels: NoiseLevels, machine: MachineKnowledge) -> EffectTrial | None:
        """Return the trial that it is time for; None for none.

        A window with such levels of noise has told so much of the machine.
        """
        return self._trials.due(self._present, machine) if is_restless(levels) else None

    def with_effects(self, effects: FloatArray, places: Collection[int]) -> MachineKnowledge:
        """Return what is known of a machine like this that has some of ``EFFECTS`` more, so large.

        What windows have told is wrong if they did not know of these places.
        """
        known, present = first_knowledge(self._motor), self._present | set(places)
        for place in present & TRIED:
            known.expected[len(FACTORS) + place] = effects[place]
        return of_present(known, present)

    def has_effects(self, effects: FloatArray, places: Collection[int]) -> None:
        """Take effects for present, and forget what windows have told without them.

        What has failed may explain more on the machine as it is known now.
        """
        self._told.clear()
        self._known, self._recalled = None, (self.with_effects(effects, places), 0.0)
        self._present |= set(places)
        self._trials = TrialTimes()

    def looks_for_cogging(self, levels: NoiseLevels) -> bool:
        """Tell whether it is time to look for cogging in a window with these levels of noise."""
        if not is_restless(levels):
            return False
        self._unsearched += 1
        if self._unsearched < SEARCH_EVERY:
            return False
        self._unsearched = 0
        return True

    def suspects_cogging(self, evidence: CoggingEvidence) -> bool:
        """Tell whether evidence suffices to try cogging, or another number of periods."""
        return evidence.gain > (OTHER_EVIDENCE if self.cogs else COGGING_EVIDENCE)

    def has_cogging(self, cogs: int) -> None:
        """Take cogging for present, so many periods in a turn."""
        self.cogs = cogs
        self._present |= COGGING
        self._trials = TrialTimes()

    def keeps_cogging(self) -> None:
        """Take note that another number of periods explains no more."""
        self._unsearched = SEARCH_EVERY - SEARCH_AGAIN

    def implausible(self, machine: MachineKnowledge) -> str:
        """Return the constant that no machine has, as a window tells it; empty if there is none."""
        known = first_knowledge(self._motor)
        off = np.abs(machine.expected - known.expected) / np.sqrt(np.diag(known.covariance))
        most = int(off.argmax())
        return (*FACTORS, *EFFECTS)[most].replace("_", " ") if off[most] > PLAUSIBLE else ""

    def voltage_offset(self, machine: MachineKnowledge) -> VoltageOffset | None:
        """Return the offset of the amplifier, once there is one.

        An offset that is not told from none is not to be compensated: in a dead zone without
        friction the motor would creep by the error.

        Parameters
        ----------
        machine : MachineKnowledge
            What the newest window has told.
        """
        offset = told_offset(machine)
        self._has_offset = self._has_offset or offset.is_one
        return offset if self._has_offset else None
