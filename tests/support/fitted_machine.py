"""What the estimator by output error makes of a machine that nobody described to it."""

from collections.abc import Callable, Collection

import numpy as np
from recorded_machine import Run, record
from unknown_machine import UnknownMachine

from bdt_plant.plant import PlantModel
from bdt_twin.next_fit import AcceptedFit
from bdt_twin.output_error import OutputErrorEstimator
from bdt_twin.output_error_settings import OutputErrorSettings


def last_fit_of_machine(
    machine: UnknownMachine,
    run: Run,
    reference: Callable[[float], float] | None = None,
    missing: Collection[int] = (),
) -> AcceptedFit:
    """Return what the last window has told that has told anything.

    Parameters
    ----------
    machine : UnknownMachine
        The machine.
    run : Run
        What its loop does, for some whole seconds.
    reference : callable, optional
        Returns the wanted position [m] at a time [s]: without one there are steps.
    missing : collection of int
        Seconds of telemetry that are lost.
    """
    rows, _ = record(machine, run, reference=reference)
    estimator = OutputErrorEstimator(PlantModel(), OutputErrorSettings(), run.sampling_rate)
    for second, batch in enumerate(np.split(rows, round(run.duration))):
        if second not in missing:
            estimator.update(batch)
    assert estimator.last_fit is not None
    return estimator.last_fit
