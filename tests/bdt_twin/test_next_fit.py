"""The fit of a window with the effects that join its unknowns."""

import math

import numpy as np
import pytest

from bdt_plant.plant import PlantModel
from bdt_twin import next_fit as module
from bdt_twin.machine_memory import MachineMemory
from bdt_twin.next_fit import MOST_NEWCOMERS, next_fit
from bdt_twin.stretch import Stretch
from bdt_twin.window_model import WindowModel

RATE, BLOCK = 1000.0, 5


class FullOfEffects(MachineMemory):
    """A machine of which each fit gives evidence of one more effect."""

    def has_evidence(self, evidence, machine):
        return True


@pytest.fixture
def fits(monkeypatch):
    """Note the fits of a window."""
    made = []
    fit_window = module.fit_window

    def noted(*arguments):
        made.append(fit_window(*arguments))
        return made[-1]

    monkeypatch.setattr(module, "fit_window", noted)
    return made


@pytest.mark.parametrize(("much", "newcomers"), [(math.inf, MOST_NEWCOMERS), (0, 0)])
def test_effects_join_one_after_the_other_and_none_where_a_fit_took_long(
    closed_loop, monkeypatch, fits, much, newcomers
):
    monkeypatch.setattr(module, "MUCH_WORK", much)
    stretch = Stretch(0, *np.ascontiguousarray(closed_loop(12.0).rows[:6000, 1:].T))
    window = WindowModel(PlantModel(), [stretch], np.arange(7.0), RATE, BLOCK)
    machine = FullOfEffects(PlantModel().motor)
    fitted, fit = next_fit(window, None, machine, math.radians(0.02))
    assert fitted is window
    assert fit.unknowns is fits[-1].unknowns
    assert fit.simulated == sum(each.simulated for each in fits)
    assert len(fits) == 1 + newcomers
