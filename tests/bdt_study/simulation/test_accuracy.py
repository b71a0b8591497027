"""The kernel against an event-located high-order reference: error and order of convergence."""

import math

import numpy as np
import pytest

from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import Sampling
from bdt_study.simulation.accuracy import (
    RATES,
    convergence_study,
    order_of,
    reference_positions,
)
from bdt_study.simulation.closed_loop import Scenario, simulate


@pytest.fixture(scope="module")
def study():
    return convergence_study()


def test_without_backlash_the_kernel_is_exact_at_every_step_size(study):
    assert max(study[0].errors) < 1e-14
    assert study[0].order is None


def test_with_backlash_the_error_is_of_second_order(study):
    assert study[1].order == pytest.approx(2.0, abs=0.3)
    errors = dict(zip(RATES, study[1].errors, strict=True))
    assert errors[5000.0] < 3e-9
    assert errors[1000.0] > 1e-8  # the contact changes are seen, not stepped over
    assert list(errors.values()) == sorted(errors.values(), reverse=True)


def test_the_reference_notices_a_gap_that_is_off_by_a_thousandth():
    gap = GapProfile(kind="constant", initial=math.radians(10.0))
    other = GapProfile(kind="constant", initial=math.radians(10.01))
    scenario = Scenario(duration=0.4, reference=0.005, gap=gap)
    position = simulate(Scenario(duration=0.4, reference=0.005, gap=other), ("q3",)).q3[::10]
    assert np.max(np.abs(position - reference_positions(scenario, gap))) > 1e-8


def test_the_kernel_converges_to_the_reference_in_a_gap_that_grows_fast():
    """At 20 degrees a second the screw's speed differs from the motor's in contact."""
    gap = GapProfile(
        kind="ramp", initial=math.radians(10.0), final=math.radians(20.0), growth_time=0.5
    )
    expected = reference_positions(Scenario(duration=0.4, reference=0.005, gap=gap), gap)

    def error(rate):
        sampling = Sampling(sampling_rate=rate)
        scenario = Scenario(duration=0.4, reference=0.005, gap=gap, sampling=sampling)
        position = simulate(scenario, ("q3",)).q3[:: sampling.samples_per_control_step]
        return np.max(np.abs(position - expected))

    assert error(5000.0) < 1e-7
    assert error(50000.0) < error(5000.0) / 30


@pytest.mark.parametrize("order", [1.0, 2.0])
def test_the_order_is_the_slope(order):
    rates = (1000.0, 2000.0, 8000.0)
    assert order_of(rates, [3.0 * rate**-order for rate in rates]) == pytest.approx(order)
