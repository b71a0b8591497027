"""Friction that yields beside rigid friction: windows are fitted the other way, too.

From rigid friction to one that yields a fit gets over hills, if at all, and back, too. So what the
machine is not thought to have is followed beside it from window to window, and believed once what
the windows tell adds up.
"""

import math
from dataclasses import replace

import numpy as np

from bdt_twin.effect_trials import TRIED
from bdt_twin.fit_result import Fit
from bdt_twin.fixed_order import mean
from bdt_twin.friction_evidence import FrictionEvidence
from bdt_twin.gap_doubt import yielding_doubt
from bdt_twin.machine_knowledge import YIELD_ANGLE
from bdt_twin.machine_memory import MachineMemory
from bdt_twin.noise_levels import is_restless
from bdt_twin.window_model import WindowModel
from bdt_twin.window_prediction import Predecessor, predicted_unknowns
from bdt_twin.window_search import fit_another_machine

EVERY = 3
"""Windows from one comparison to the next where the machine's friction is certain."""
MUCH_WORK = 500_000
"""Simulated samples of a window's own fits that leave no time for another one."""
LEAST_FRICTION = 5e-3
"""Voltage of the friction from which on it matters whether it yields [V]."""
FIRST_ANGLE, SMALLEST_ANGLE, LARGEST_ANGLE = 2e-3, 1e-3, 2e-2
"""Yield angle with which the first fit of friction that yields begins, and least and largest ones
of those that begin anew [rad]."""
CLEAR_GAIN = 5.0
"""Gain of log-likelihood from which on fits that begin anew begin with the angle of this one."""
ASTRAY = 1000.0
"""Loss of log-likelihood from which on a fit with the other friction begins anew from that of the
machine."""


class AlternativeFriction:
    """Follows the machine with the other friction: yielding beside rigid, or the other way round.

    Windows are compared that the machine's own fit leaves restless, for there is nothing to be
    explained in others, and if there is time for it.
    """

    def __init__(self) -> None:
        self._evidence = FrictionEvidence()
        self._rest = 0
        self._angle = FIRST_ANGLE
        self._machine: MachineMemory | None = None
        self._last: Predecessor | None = None

    def doubt(self, fit: Fit) -> float:
        """Return the standard uncertainty of a gap because friction may not be as it is thought.

        Parameters
        ----------
        fit : Fit
            The fit that tells the gap.

        Returns
        -------
        float
            The uncertainty [rad].
        """
        hidden = yielding_doubt(fit, openness=self._evidence.openness)
        return math.hypot(hidden, self._evidence.doubt)

    def better(
        self, window: WindowModel, fit: Fit, machine: MachineMemory, growth_change: float
    ) -> tuple[MachineMemory, Fit]:
        """Return what is known of the machine with the friction that is believed, and its fit.

        Parameters
        ----------
        window : WindowModel
            The newest window.
        fit : Fit
            Its fit.
        machine : MachineMemory
            What is known of the machine.
        growth_change : float
            Scale of the growth rate's change in one second [rad/s^1.5].

        Returns
        -------
        machine : MachineMemory
            The given one, or that of the machine with the other friction.
        fit : Fit
            Its fit, with the work of both.
        """
        if not machine.has_friction(fit.machine, LEAST_FRICTION):
            return machine, fit
        if not is_restless(fit.levels):
            self._evidence.explained()
            return machine, fit
        self._rest -= 1
        if self._rest > 0 or fit.simulated > MUCH_WORK:
            return machine, fit
        if self._machine is None or not (machine.present & TRIED) <= self._machine.present:
            # What it was told without what was tried is wrong.
            self._machine, self._last = machine.with_yield_angle(self._other_angle(machine)), None
        other = self._machine
        found = self._fit(window, fit, machine, other, growth_change)
        self._compare(window, fit, found, other)
        self._rest = EVERY if self._evidence.is_certain else 1
        work = fit.simulated + found.simulated
        if not self._evidence.is_against:
            return machine, replace(fit, simulated=work)
        self._evidence.turn()
        self._machine, self._last = machine, Predecessor(window, fit, 0.0)
        return other, replace(found, simulated=work)

    def _other_angle(self, machine: MachineMemory) -> float:
        return 0.0 if YIELD_ANGLE in machine.present else self._angle

    def _fit(
        self,
        window: WindowModel,
        fit: Fit,
        machine: MachineMemory,
        other: MachineMemory,
        growth_change: float,
    ) -> Fit:
        """Return the fit of a window with the other friction."""
        if self._last is None:
            begun, levels = fit.unknowns.with_yield_angle(self._other_angle(machine)), fit.levels
        else:
            begun, levels = predicted_unknowns(window, self._last), self._last.fit.levels
        other.be_like(machine)
        known = other.before(*window.span)
        return fit_another_machine(window, growth_change, known, begun, levels)

    def _compare(self, window: WindowModel, fit: Fit, found: Fit, other: MachineMemory) -> None:
        """Take note of a fit with the other friction."""
        gain, angle = found.gain_over(fit), None
        if YIELD_ANGLE in other.present:
            angle = float(found.unknowns.effects[YIELD_ANGLE])
            if gain > CLEAR_GAIN:
                self._angle = min(max(angle, SMALLEST_ANGLE), LARGEST_ANGLE)
        self._last = Predecessor(window, found, 0.0) if gain > -ASTRAY else None
        if gain > 0.0:
            other.learn(window.span[1], found.machine)
        difference = mean(np.abs(found.unknowns.gaps - fit.unknowns.gaps))
        self._evidence.compared(gain, difference, angle)
