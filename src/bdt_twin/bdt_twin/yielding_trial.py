"""Whether friction yields before it slides: that has to prove itself again and again.

A fit that has ended too early gives evidence of it, too, and one that begins with it takes some
windows to get there.
"""

import numpy as np

from bdt_twin.fixed_order import dot, total
from bdt_twin.machine_knowledge import YIELDS, MachineKnowledge
from bdt_twin.model_factors import FACTORS
from bdt_twin.yielding_friction import YIELD_ANGLES

YIELDING_EVIDENCE = 12.0
"""Gain of log-likelihood by friction that yields at one of the angles for which it is tried."""
FIRST, AGAIN = 4, 30
"""Answers before the first trial, for what is hardly known tells nothing of this, and from a trial
that has failed to the next one."""
TRIAL = 6
"""Windows after which friction has to be one that yields."""
SMALLEST_SHARE, SMALLEST_ANGLE = 0.5, 2e-3
"""Share of the friction that yields if any does, and mean angle over which it does so [rad]: a
little of both makes up for what a fit has not reached yet."""


class YieldingTrial:
    """Counts windows with friction that yields, and answers without."""

    def __init__(self) -> None:
        self._rest, self._windows = FIRST, 0

    @property
    def may_begin(self) -> bool:
        """Whether it is time for a trial."""
        return self._rest == 0

    def answer(self) -> None:
        """Take note of a window that has told the gap."""
        self._rest = max(self._rest - 1, 0)

    def begin(self) -> None:
        """Begin a trial."""
        self._windows = 0

    def has_failed(self, machine: MachineKnowledge) -> bool:
        """Take note of a window with friction that yields; tell whether it turns out to be rigid.

        Parameters
        ----------
        machine : MachineKnowledge
            What the window has told.
        """
        self._windows += 1
        if self._windows % TRIAL:
            return False
        if yields(machine):
            return False
        self._rest = AGAIN
        return True


def yields(machine: MachineKnowledge) -> bool:
    """Tell whether most of the friction yields, over an angle that matters.

    Parameters
    ----------
    machine : MachineKnowledge
        What a window has told.
    """
    shares = machine.expected[len(FACTORS) + np.array(YIELDS)]
    return total(shares) > SMALLEST_SHARE and dot(shares, np.array(YIELD_ANGLES)) > SMALLEST_ANGLE
