"""Which windows no fit explains."""

from types import SimpleNamespace

import numpy as np
import pytest

from bdt_plant.motor import MotorParameters
from bdt_twin.machine_knowledge import EFFECTS, first_knowledge
from bdt_twin.machine_memory import MachineMemory
from bdt_twin.model_factors import FACTORS
from bdt_twin.unexplained_window import unexplained

MACHINE = MachineMemory(MotorParameters())


def fit(*, error=1e-6, residual=1e-6, travel=50.0, delay=0.0):
    """Return a fit of 20 s in which the platform moves by a millimeter."""
    known = first_knowledge(MotorParameters())
    constants = known.expected.copy()
    constants[len(FACTORS) + EFFECTS.index("delay")] = delay
    return SimpleNamespace(
        responses=[SimpleNamespace(position=np.array([-1e-3, 1e-3]), travel=travel)],
        prediction_error=error,
        residual=residual,
        machine=known._replace(expected=constants),
    )


def test_a_fit_that_predicts_its_window_explains_it():
    assert unexplained(fit(), 1, MACHINE) == ""


@pytest.mark.parametrize(
    ("constants", "reversals", "reason"),
    [
        ({"travel": 0.0}, 1, "the lead screw does not move"),
        ({}, 0, "the lead screw does not reverse"),
        ({"error": 30e-6}, 1, "the model does not explain 30 um of a motion of 1e+03 um"),
        ({"residual": 3e-4}, 1, "the model does not explain 300 um of a motion of 1e+03 um"),
        ({"delay": 0.01}, 1, "only an odd delay would explain the data"),
    ],
)
def test_why_a_window_is_not_explained(constants, reversals, reason):
    assert unexplained(fit(**constants), reversals, MACHINE) == reason
