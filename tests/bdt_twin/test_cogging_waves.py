"""Slopes of the position for waves of the motor's angle, against simulations with such cogging."""

import math
from dataclasses import replace

import numpy as np
import pytest
from fitted_machine import last_fit_of_machine
from recorded_machine import Run
from unknown_machine import UnknownMachine

from bdt_twin.block_residual import BlockResidual
from bdt_twin.cogging_waves import NUMBERS, wave_slopes
from bdt_twin.machine_knowledge import COGGING

CHANGE = 1e-5


@pytest.fixture(scope="module")
def explained():
    """Return window and fit of a machine that often turns slowly, with a hole in its telemetry."""
    machine = UnknownMachine(coulomb_friction=0.02, friction_at_rest=0.03, stribeck_speed=4.0)

    def slow_sines(time):
        return 3e-3 * (1.0 - math.cos(time))

    last = last_fit_of_machine(machine, Run(duration=15.0), slow_sines, missing=[6])
    return last.window, last.fit


def simulated_slope(window, fit, cogs, part):
    """Return the slope of the position for a part of a wave, from two simulations."""

    def residual(cogging):
        effects = fit.unknowns.effects.copy()
        effects[sorted(COGGING)[part]] = cogging
        runs = window.with_cogs(cogs).simulate(replace(fit.unknowns, effects=effects))
        means = BlockResidual(window.stretches, window.block).means
        return means([run.position for run in runs])

    return (residual(-CHANGE) - residual(CHANGE)) / (2.0 * CHANGE)


def test_a_wave_moves_the_position_as_cogging_of_this_number_does(explained):
    """Nearly: cogging moves the contacts, too, and holds a motor that has come to rest."""
    window, fit = explained
    assert len(window.stretches) == 2
    slopes, alike, own = wave_slopes(window, fit), 0.0, 0.0
    for cogs in (4, 12, 24, 36, 48):
        for part in (0, 1):
            slope = simulated_slope(window, fit, cogs, part)
            found = slopes[2 * NUMBERS.index(cogs) + part]
            assert np.corrcoef(found, slope)[0, 1] > 0.9
            alike += np.dot(found, slope)
            own += np.dot(slope, slope)
    assert alike / own == pytest.approx(1.0, abs=0.1)
