"""The pitch of the lead screw that a run is looked at with."""

from bdt_bags.run_signals import RunSignals
from bdt_plant.lead_screw import LeadScrewParameters


def lead_screw_pitch(run: RunSignals) -> float:
    """Return the pitch of the lead screw [m/rad]: the paper's where a recording tells none."""
    return LeadScrewParameters().pitch if run.pitch is None else run.pitch
