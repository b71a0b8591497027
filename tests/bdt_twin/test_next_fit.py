"""The fit of a window with the effects that join its unknowns."""

import math

import numpy as np
import pytest
from recorded_machine import Run, record
from unknown_machine import UnknownMachine

from bdt_plant.motor import MotorParameters
from bdt_plant.plant import PlantModel
from bdt_twin import next_fit as module
from bdt_twin.cogging_search import CoggingEvidence
from bdt_twin.innovations import NoiseLevels
from bdt_twin.machine_knowledge import COGGING, EFFECTS, THREAD, TOP_MASS, VOLTAGE_LAG
from bdt_twin.machine_memory import SEARCH_AGAIN, MachineMemory
from bdt_twin.next_fit import MOST_NEWCOMERS, next_fit
from bdt_twin.stretch import Stretch
from bdt_twin.window_model import WindowModel
from bdt_twin.window_prediction import Predecessor

RATE, BLOCK = 1000.0, 5
RESTLESS = NoiseLevels(1e-6, slow=1e-4)


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


@pytest.fixture(scope="module")
def cogged():
    """Return a window of a motor with 24 cogs in a turn."""
    machine = UnknownMachine(coulomb_friction=0.02, cogging=3e-3)
    rows, _ = record(machine, Run(duration=20.0, sampling_rate=RATE, step_time=3.0))
    stretch = Stretch(0, *np.ascontiguousarray(rows[:, 1:].T))
    return WindowModel(PlantModel(), [stretch], np.arange(21.0), RATE, BLOCK)


def memory_with(cogs):
    memory = MachineMemory(MotorParameters(coulomb_friction=0.02))
    memory.has_cogging(cogs)
    return memory


def followed(cogged, memory, windows):
    """Return the last of some fits of the same data, each of which begins with the one before."""
    last = None
    for _ in range(windows):
        window = cogged.with_cogs(memory.cogs)
        last = Predecessor(*next_fit(window, last, memory, math.radians(0.02)), 0.0)
    return last


def told_of(machine, windows):
    """Return what some fits of 8 s of a machine have told of it, and the last one."""
    rows, _ = record(machine, Run(duration=8.0, sampling_rate=5000.0, step_time=2.0))
    stretch = Stretch(0, *np.ascontiguousarray(rows[:, 1:].T))
    window = WindowModel(PlantModel(), [stretch], np.arange(9.0), 5000.0, 25)
    memory, last = MachineMemory(MotorParameters()), None
    for _ in range(windows):
        last = Predecessor(*next_fit(window, last, memory, math.radians(0.02)), 0.0)
    return memory, last


@pytest.mark.parametrize(("lag", "delay"), [(1.5e-3, 0.0), (1e-3, 4e-4), (0.0, 1.2e-3)])
def test_a_voltage_that_is_late_is_told_from_a_reading_that_is(lag, delay):
    machine = UnknownMachine(coulomb_friction=8e-3, amplifier_lag=lag, delay=delay)
    memory, last = told_of(machine, 10)
    told = dict(zip(EFFECTS, last.fit.unknowns.effects.tolist(), strict=True))
    assert (VOLTAGE_LAG in memory.present) == (lag > 0.0)
    assert told["voltage_lag"] == pytest.approx(lag, abs=1e-4)
    assert told["delay"] == pytest.approx(delay, abs=1e-4)


@pytest.mark.parametrize(
    ("constants", "factor"),
    [
        ({"upper_mass": 1.3}, 1.3),
        ({"upper_mass": 0.8}, 0.8),
        ({"mass": 1.3 * 5.2, "upper_mass": 1.0 / 1.3}, 1.0 / 1.3),
        ({"upper_stiffness": 0.8}, 0.8),
        ({"damping": 45.0, "cubic_stiffness": 2e6}, 1.0),
    ],
)
def test_the_top_platform_has_another_mass_where_both_modes_tell(constants, factor):
    """Softer upper beams are the same: the two modes of the structure are all that is read."""
    memory, last = told_of(UnknownMachine(coulomb_friction=8e-3, **constants), 8)
    assert (TOP_MASS in memory.present) == (factor != 1.0)
    assert math.exp(last.fit.unknowns.effects[TOP_MASS]) == pytest.approx(factor, rel=0.05)


@pytest.mark.parametrize("error", [2e-6, 0.0])
def test_a_thread_is_off_where_the_travel_repeats_with_each_turn(error):
    machine = UnknownMachine(coulomb_friction=8e-3, thread_error=error)
    memory, last = told_of(machine, 6)
    assert memory.present.issuperset(THREAD) == (error > 0.0)
    sine, cosine = last.fit.unknowns.effects[sorted(THREAD)]
    assert sine == pytest.approx(error, abs=5e-8)
    assert cosine == pytest.approx(0.0, abs=5e-8)


@pytest.mark.parametrize("wrong", [12, 23])
def test_a_wrong_number_of_periods_gives_way_to_the_right_one(cogged, wrong):
    memory = memory_with(wrong)
    last = followed(cogged, memory, 4)
    assert last.window.cogs == memory.cogs == 24
    size = math.hypot(*(last.fit.unknowns.effects[place] for place in sorted(COGGING)))
    assert size == pytest.approx(3e-3 / 0.8 * 12.0, rel=0.2)


def test_a_number_of_periods_that_only_seems_to_explain_more_is_not_taken(
    cogged, monkeypatch, fits
):
    memory = memory_with(24)
    last = followed(cogged, memory, 3)
    fits.clear()
    monkeypatch.setattr(module, "cogging_evidence", lambda *_: CoggingEvidence(17, 50.0))
    monkeypatch.setattr(MachineMemory, "looks_for_cogging", lambda *_: True)
    fitted, fit = next_fit(last.window, last, memory, math.radians(0.02))
    tried, refused = fits
    assert fitted.cogs == memory.cogs == 24
    assert fit.unknowns is tried.unknowns
    assert fit.simulated == tried.simulated + refused.simulated
    monkeypatch.undo()
    assert not any(memory.looks_for_cogging(RESTLESS) for _ in range(SEARCH_AGAIN - 1))
