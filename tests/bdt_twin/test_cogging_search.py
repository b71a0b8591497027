"""Cogging is found with its number of periods, where there is some, on an independent machine."""

from functools import cache

import numpy as np
import pytest
from recorded_machine import Run, record
from unknown_machine import UnknownMachine

from bdt_plant.plant import PlantModel
from bdt_twin.cogging_search import cogging_evidence
from bdt_twin.machine_memory import COGGING_EVIDENCE
from bdt_twin.output_error import OutputErrorEstimator
from bdt_twin.output_error_settings import OutputErrorSettings

RATE = 1000.0
FRICTION = 0.02


@cache
def estimator_of(cogging, cogs):
    machine = UnknownMachine(coulomb_friction=FRICTION, cogging=cogging, cogs=cogs)
    rows, _ = record(machine, Run(duration=20.0, sampling_rate=RATE, step_time=3.0))
    estimator = OutputErrorEstimator(PlantModel(), OutputErrorSettings(), RATE)
    for batch in np.split(rows, 20):
        estimator.update(batch)
    return estimator


def test_there_is_no_evidence_of_cogging_without_any():
    fit = estimator_of(0.0, 24.0).last_fit
    assert cogging_evidence(fit.window, fit.fit).gain < COGGING_EVIDENCE


@pytest.mark.parametrize("cogs", [12, 24])
def test_cogging_is_found_with_its_periods_and_its_size(cogs):
    fit = estimator_of(3e-3, float(cogs)).last_fit
    assert fit.window.cogs == cogs
    size = np.hypot(*fit.fit.unknowns.effects[-2:])
    assert size == pytest.approx(3e-3 / 0.8 * 12.0, rel=0.2)
