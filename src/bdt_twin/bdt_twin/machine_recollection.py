"""What is kept of a machine beyond the end of the twin."""

from typing import NamedTuple

from bdt_twin.machine_knowledge import MachineKnowledge


class MachineRecollection(NamedTuple):
    """What windows have told of a machine, for the next twin.

    Attributes
    ----------
    machine : MachineKnowledge
        What the newest window has told.
    present : frozenset of str
        Names of the ``EFFECTS`` that the machine has.
    cogs : int
        Periods of the motor's cogging in a turn; 0 for none.
    has_offset : bool
        Whether the amplifier's offset is told from none.
    """

    machine: MachineKnowledge
    present: frozenset[str]
    cogs: int
    has_offset: bool
