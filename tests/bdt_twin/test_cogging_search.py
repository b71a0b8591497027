"""Cogging is found with its number of periods, where there is some, on an independent machine."""

from functools import cache

import numpy as np
import pytest
from fitted_machine import last_fit_of_machine
from recorded_machine import Run
from unknown_machine import UnknownMachine

from bdt_twin.cogging_search import cogging_evidence
from bdt_twin.machine_knowledge import COGGING
from bdt_twin.machine_memory import COGGING_EVIDENCE

FRICTION = 0.02


@cache
def last_fit(cogging, cogs):
    machine = UnknownMachine(coulomb_friction=FRICTION, cogging=cogging, cogs=cogs)
    return last_fit_of_machine(machine, Run(duration=20.0, step_time=3.0))


def test_there_is_no_evidence_of_cogging_without_any():
    fit = last_fit(0.0, 24.0)
    assert cogging_evidence(fit.window, fit.fit).gain < COGGING_EVIDENCE


@pytest.mark.parametrize("cogs", [12, 24])
def test_cogging_is_found_with_its_periods_and_its_size(cogs):
    fit = last_fit(3e-3, float(cogs))
    assert fit.window.cogs == cogs
    size = np.hypot(*fit.fit.unknowns.effects[sorted(COGGING)])
    assert size == pytest.approx(3e-3 / 0.8 * 12.0, rel=0.2)
