"""Whether friction yields before it slides: now and then a window is fitted the other way, too.

From rigid friction to one that yields a fit gets over hills, if at all, and back, too. So what the
machine is not thought to have is followed beside it from window to window. What explains the data
better each time is believed: a fit that has not come to its end may gain by anything, but not by
the same angle again and again.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from bdt_twin.fit_result import Fit
from bdt_twin.machine_knowledge import YIELD_ANGLE
from bdt_twin.machine_memory import MachineMemory
from bdt_twin.noise_levels import is_restless, quiet
from bdt_twin.output_error_fit import WindowFit
from bdt_twin.window_model import WindowModel
from bdt_twin.window_prediction import Predecessor, predicted_unknowns
from bdt_twin.window_search import FINE

EVERY = 2
"""Windows from one comparison to the next: each of them takes another fit."""
MUCH_WORK = 250_000
"""Simulated samples of a window's own fits that leave no time for another one."""
MOST_SAMPLES, FEWEST_SIMULATIONS = 240_000, 3
"""Samples that a fit may simulate, and simulations that it may make however long the window is."""
LEAST_FRICTION = 5e-3
"""Voltage of the friction from which on it matters whether it yields [V]."""
FIRST_ANGLE, SMALLEST_ANGLE, LARGEST_ANGLE = 2e-3, 1e-3, 2e-2
"""Yield angle with which the first fit of friction that yields begins, and least and largest ones
of those that begin anew [rad]."""
COMPARISONS = 8
"""Comparisons in a row that have to agree: a motor whose cogging nobody has found passes six."""
LEAST_GAIN, TOTAL_GAIN = 5.0, 400.0
"""Gain of log-likelihood by friction that yields in each of them, and in all of them together."""
FEWEST_COMPARISONS, GREAT_GAIN = 5, 100.0
"""Comparisons that suffice where each gains that much."""
ALIKE = 1.3
"""Largest of their yield angles over the smallest one."""
LOST, ASTRAY = 60.0, 1000.0
"""Loss of log-likelihood from which on a fit begins anew from that of the machine, and of one that
is no comparison."""


class _Comparison(NamedTuple):
    """How much log-likelihood the other friction gains, and the angle by which either yields."""

    gain: float
    angle: float


class AlternativeFriction:
    """Follows the machine with the other friction: yielding beside rigid, or the other way round.

    Windows are compared that the machine's own fit leaves restless, for there is nothing to be
    explained in others, and if there is time for it.
    """

    def __init__(self) -> None:
        self._rest = 1
        self._angle = FIRST_ANGLE
        self._machine: MachineMemory | None = None
        self._last: Predecessor | None = None
        self._comparisons: deque[_Comparison] = deque(maxlen=COMPARISONS)

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
        if not (is_restless(fit.levels) and machine.has_friction(fit.machine, LEAST_FRICTION)):
            return machine, fit
        self._rest -= 1
        if self._rest > 0 or fit.simulated > MUCH_WORK:
            return machine, fit
        self._rest = EVERY
        if self._machine is None:
            self._machine = machine.with_yield_angle(self._other_angle(machine))
        other = self._machine
        found = self._fit(window, fit, machine, other, growth_change)
        self._compare(window, fit, found, other)
        work = fit.simulated + found.simulated
        if not self._is_believed(other):
            return machine, replace(fit, simulated=work)
        self._comparisons.clear()
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
        problem = WindowFit(window, growth_change, other.before(*window.span))
        simulations = max(MOST_SAMPLES // window.samples, FEWEST_SIMULATIONS)
        # What a model explains is not taken for a walk of the motor only because it was before.
        first = quiet(levels) if is_restless(levels) else levels
        return problem.solve(begun, FINE, simulations, levels=first)

    def _compare(self, window: WindowModel, fit: Fit, found: Fit, other: MachineMemory) -> None:
        """Take note of a fit with the other friction."""
        gain = found.gain_over(fit)
        yielding = found if YIELD_ANGLE in other.present else fit
        angle = float(yielding.unknowns.effects[YIELD_ANGLE])
        if yielding is found:
            self._angle = min(max(angle, SMALLEST_ANGLE), LARGEST_ANGLE)
        self._last = Predecessor(window, found, 0.0) if gain > -LOST else None
        if gain > 0.0:
            other.learn(window.span[1], found.machine)
        if gain > -ASTRAY:
            self._comparisons.append(_Comparison(gain, angle))

    def _is_believed(self, other: MachineMemory) -> bool:
        """Tell whether the other friction has explained the data better each time."""
        all_of_them = list(self._comparisons)
        if YIELD_ANGLE not in other.present:
            return len(all_of_them) == COMPARISONS and _least_gain(all_of_them) > 0.0
        newest = all_of_them[-FEWEST_COMPARISONS:]
        if len(newest) == FEWEST_COMPARISONS and _least_gain(newest) > GREAT_GAIN:
            return are_alike([each.angle for each in newest])
        return (
            len(all_of_them) == COMPARISONS
            and _least_gain(all_of_them) > LEAST_GAIN
            and sum(each.gain for each in all_of_them) > TOTAL_GAIN
            and are_alike([each.angle for each in all_of_them])
        )


def _least_gain(comparisons: list[_Comparison]) -> float:
    return min(each.gain for each in comparisons)


def are_alike(angles: Sequence[float]) -> bool:
    """Tell whether yield angles that several fits have found are those of one friction.

    Parameters
    ----------
    angles : sequence of float
        The angles [rad].
    """
    return max(angles) < ALIKE * min(angles)
