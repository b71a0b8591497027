"""The voltage that an amplifier adds to its commands, as a window tells it."""

import math
from typing import NamedTuple

from bdt_twin.machine_knowledge import EFFECTS, MachineKnowledge
from bdt_twin.model_factors import FACTORS

SMALLEST_OFFSET = 1e-3
"""Voltage [V] up to which an amplifier's offset is none."""
OFFSET_COVERAGE = 5.0
"""Standard uncertainties by which an offset differs from none before it is one."""


class VoltageOffset(NamedTuple):
    """Voltage that the amplifier adds, and its standard uncertainty [V]."""

    voltage: float
    uncertainty: float

    @property
    def is_one(self) -> bool:
        """Whether it is told from none."""
        return abs(self.voltage) > max(OFFSET_COVERAGE * self.uncertainty, SMALLEST_OFFSET)


def told_offset(machine: MachineKnowledge) -> VoltageOffset:
    """Return the offset as a window has told it.

    Parameters
    ----------
    machine : MachineKnowledge
        What it has told.
    """
    place = len(FACTORS) + EFFECTS.index("voltage_offset")
    uncertainty = math.sqrt(float(machine.covariance[place, place]))
    return VoltageOffset(float(machine.expected[place]), uncertainty)
