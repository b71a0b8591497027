"""Whether a fit explains the data of its window."""

from bdt_twin.fit_result import Fit
from bdt_twin.fixed_order import standard_deviation
from bdt_twin.forward_model import SMALLEST_TRAVEL
from bdt_twin.machine_memory import MachineMemory

MISFIT = 0.02
"""Share of the position's motion that is not predicted in a window that is explained."""
UNEXPLAINED = 0.1
"""Share of a residual that is unexplained even if noise of the machine would make it likely."""


def unexplained(fit: Fit, reversals: int, machine: MachineMemory) -> str:
    """Return why a fit is none of the data; empty if it is.

    Parameters
    ----------
    fit : Fit
        The fit of a window.
    reversals : int
        Reversals of the screw that the platform has answered.
    machine : MachineMemory
        What is known of the machine.
    """
    motion = max(standard_deviation(run.position) for run in fit.responses)
    if sum(run.travel for run in fit.responses) < SMALLEST_TRAVEL:
        return "the lead screw does not move"
    if not reversals:
        return "the lead screw does not reverse"
    if max(fit.prediction_error, UNEXPLAINED * fit.residual) > MISFIT * motion:
        error = max(fit.prediction_error, fit.residual)
        return (
            f"the model does not explain {1e6 * error:.3g} um of a motion of {1e6 * motion:.3g} um"
        )
    if strange := machine.implausible(fit.machine):
        return f"only an odd {strange} would explain the data"
    return ""
