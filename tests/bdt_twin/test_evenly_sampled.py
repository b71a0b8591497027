"""An estimator knows as much from a machine's telemetry as from a simulator's."""

import numpy as np
import pytest

from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import PlantModel
from bdt_twin.estimator import Estimate
from bdt_twin.evenly_sampled import EvenlySampled
from bdt_twin.next_fit import AcceptedFit
from bdt_twin.output_error import OutputErrorEstimator
from bdt_twin.output_error_settings import OutputErrorSettings

RATE = 1000.0
PROFILE = GapProfile(kind="constant", initial=float(np.deg2rad(8.0)))


class Collecting:
    """An estimator that keeps what it gets."""

    last_fit = AcceptedFit(window=None, fit=None, estimate=Estimate(0.1, 0.01))

    def __init__(self):
        self.batches, self.restarts = [], 0

    def restart(self):
        self.restarts += 1

    def update(self, batch, *, newest_only=False):
        self.batches.append(batch)
        return Estimate(float(batch[-1, 0]), 0.1 if newest_only else 0.2)


def test_even_batches_arrive_as_they_are():
    inner = Collecting()
    outer = EvenlySampled(inner, 10.0)
    rows = np.column_stack([np.arange(10) / 10.0, np.zeros((10, 2))])
    assert outer.update(rows).gap == 0.2
    assert outer.update(rows + np.array([1.0, 0.0, 0.0]), newest_only=True).gap == 0.1
    assert inner.batches[0] is rows
    assert outer.last_fit is inner.last_fit
    assert outer.sampling.is_even


def test_what_has_to_wait_for_the_next_batch_is_no_estimate_yet():
    inner = Collecting()
    outer = EvenlySampled(inner, 10.0)
    rows = np.column_stack([np.array([0.0, 0.13, 0.2]), np.zeros((3, 2))])
    assert outer.update(rows) is None
    assert not inner.batches
    assert outer.update(rows + np.array([0.3, 0.0, 0.0])) is not None
    outer.restart()
    assert inner.restarts == 1
    assert outer.sampling.is_even


@pytest.mark.parametrize("how", ["stamped late", "taken late", "slow clock"])
def test_jitter_costs_little(closed_loop, how):
    rows = closed_loop(PROFILE, 13.0).rows.copy()
    generator = np.random.default_rng(0)
    rows[:, 2] += generator.normal(0.0, 1e-6, len(rows))
    jitter = np.clip(generator.normal(0.0, 1e-4, len(rows)), -4e-4, 4e-4)
    if how == "stamped late":
        rows[:, 0] += jitter
    if how == "taken late":
        times = rows[:, 0] + jitter
        rows[:, 2] = np.interp(times, rows[:, 0], rows[:, 2])
        rows[:, 0] = times
    if how == "slow clock":
        rows[:, 0] = 1.002 * rows[:, 0] + 0.5 * jitter
    estimator = OutputErrorEstimator(PlantModel(), OutputErrorSettings(), RATE)
    outer = EvenlySampled(estimator, RATE)
    estimates = [outer.update(batch) for batch in np.split(rows, range(500, len(rows), 500))]
    learned = [each for each in estimates if each is not None and not each.reason]
    assert len(learned) >= 8
    errors = np.rad2deg([each.gap for each in learned]) - 8.0
    assert np.sqrt(np.mean(errors[3:] ** 2)) < 0.1
    assert not outer.sampling.is_even


def test_what_is_known_of_a_machine_goes_through_to_the_estimator_and_back():
    class Remembers:
        recollection = None

        def recall(self, kept, age):
            self.recollection = kept, age

    remembers = EvenlySampled(Remembers(), 1000.0)
    assert remembers.recollection is None
    remembers.recall("kept", 5.0)
    assert remembers.recollection == ("kept", 5.0)
    forgets = EvenlySampled(object(), 1000.0)
    forgets.recall("kept", 5.0)
    assert forgets.recollection is None
