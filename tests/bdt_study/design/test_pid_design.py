"""The PID design against the paper's demands, checked with formulas written out once more."""

import math
from dataclasses import astuple

import numpy as np
import pytest

from bdt_controller.pid import INITIAL_PID, PidGains, discretize_pid, pid_step
from bdt_plant.plant import AT_REST, PlantModel, discretize_plant, plant_step
from bdt_plant.structure import StructureParameters
from bdt_study.design.pid_design import design_pid

M, K, C = 5.2, 1e4, 36.9
PITCH = 1e-3 / (2 * math.pi)
FREQUENCY = np.unique(np.concatenate([np.geomspace(0.1, 3000, 20001), np.linspace(8, 32, 20001)]))


def loop_at(frequency, gains):
    """Return L of eqs 1 to 5 with table 1."""
    k_p, k_i, k_d, t_f = gains
    s = 1j * np.asarray(frequency)
    motor = 0.8 / (5e-9 * s**2 + 6e-5 * s + 0.08) / s
    stiff = (C * s + K) ** 2
    structure = stiff / (
        M**2 * s**4 + 3 * C * M * s**3 + (C**2 + 3 * K * M) * s**2 + 2 * C * K * s + K**2
    )
    return (k_p + k_i / s + k_d * s / (t_f * s + 1)) * motor * PITCH * structure


def closed_loop_poles(gains):
    k_p, k_i, k_d, t_f = gains
    poly = np.polynomial.Polynomial
    top = poly([k_i, k_p + k_i * t_f, k_p * t_f + k_d]) * poly([K, C]) ** 2 * 0.8 * PITCH
    bottom = poly([0, 0, 1, t_f]) * poly([0.08, 6e-5, 5e-9])
    bottom = bottom * poly([K**2, 2 * C * K, C**2 + 3 * K * M, 3 * C * M, M**2])
    return (top + bottom).roots()


def margins_at(gains):
    """Return crossovers, smallest phase margin [rad] and M_s on a fine grid."""
    loop = loop_at(FREQUENCY, gains)
    above = np.abs(loop) > 1
    crossings = np.flatnonzero(above[1:] != above[:-1])
    smallest = np.abs(np.angle(-loop[crossings])).min()
    return FREQUENCY[crossings], smallest, (1 / np.abs(1 + loop)).max()


def gains_for(lead, filter_time, integral_time=0.1, bandwidth=10.0):
    """Return the gains with |L| = 1 at the bandwidth, for K_d / K_p and T_f."""
    shape = (1.0, 1.0 / integral_time, lead, filter_time)
    size = 1.0 / abs(loop_at(bandwidth, shape))
    return (size, size / integral_time, size * lead, filter_time)


def test_the_first_crossover_is_at_10_rad_per_s(design):
    crossovers, _, _ = margins_at(astuple(design.gains))
    assert crossovers[0] == pytest.approx(10.0, rel=2e-3)
    assert abs(loop_at(10.0, astuple(design.gains))) == pytest.approx(1.0, rel=1e-9)
    assert design.margins.first_crossover == pytest.approx(10.0, rel=1e-9)


def test_the_bandwidth_of_t_is_reported_beside_it(design):
    loop = loop_at(FREQUENCY, astuple(design.gains))
    below = np.abs(loop / (1 + loop)) < math.sqrt(0.5)
    assert design.margins.bandwidth == pytest.approx(FREQUENCY[below.argmax()], rel=2e-4)
    assert design.margins.bandwidth == pytest.approx(27.8, abs=0.05)


def test_every_phase_margin_is_at_least_10_degrees(design):
    crossovers, smallest, _ = margins_at(astuple(design.gains))
    assert len(crossovers) == len(design.margins.crossovers) == 3
    assert math.degrees(smallest) == pytest.approx(16.75, abs=0.1)
    assert design.margins.smallest_phase_margin == pytest.approx(smallest, abs=2e-3)


def test_the_closed_loop_is_stable(design):
    assert design.margins.stable
    assert design.sampled.stable
    assert closed_loop_poles(astuple(design.gains)).real.max() < -1.5


def test_the_maximum_sensitivity_is_the_smallest_there_is(design):
    """No other stable PID with this crossover and integral time keeps L further from -1."""
    _, _, reached = margins_at(astuple(design.gains))
    assert design.margins.maximum_sensitivity == pytest.approx(reached, rel=1e-6)
    assert reached == pytest.approx(3.655, abs=1e-3)
    lead = design.gains.derivative / design.gains.proportional
    for change in (0.9, 0.99, 1.0, 1.01, 1.1):
        for other in (0.9, 0.99, 1.0, 1.01, 1.1):
            gains = gains_for(change * lead, other * design.gains.filter_time)
            assert margins_at(gains)[2] >= reached * (1 - 1e-5)


def test_no_random_pid_does_better(design):
    _, _, reached = margins_at(astuple(design.gains))
    random = np.random.default_rng(3)
    tried = 0
    for _ in range(400):
        filter_time = math.exp(random.uniform(math.log(3e-3), math.log(3.0)))
        gains = gains_for(random.uniform(-3.0, 5.0) * filter_time, filter_time)
        crossovers, smallest, sensitivity = margins_at(gains)
        early = crossovers[0] < 9.99
        if early or smallest < math.radians(10) or closed_loop_poles(gains).real.max() >= 0:
            continue
        tried += 1
        assert sensitivity >= reached
    assert tried > 3


def test_the_shipped_gains_come_out_of_the_design(design):
    """To a part in a thousand: the shipped numbers are rounded, and the optimum is flat."""
    assert astuple(PidGains()) == pytest.approx(astuple(design.gains), rel=1e-3)


def test_the_step_response_of_the_cores_ends_at_the_reference(design):
    plant, pid = discretize_plant(PlantModel(), 1e-3), discretize_pid(design.gains, 2e-3)
    state, controller, positions = AT_REST, INITIAL_PID, []
    for _ in range(6000):
        positions.append(state.structure.q3)
        controller, voltage = pid_step(controller, 5e-3 - state.structure.q3, pid)
        for _ in range(2):
            state = plant_step(state, voltage, 0.0, plant)
    assert positions[-1] == pytest.approx(5e-3, rel=1e-6)
    # A crossover at 10 rad/s: the reference is first reached after some 2 / (10 rad/s).
    assert np.argmax(np.array(positions) > 5e-3) * 2e-3 == pytest.approx(0.2, abs=0.05)


def test_the_design_is_the_same_on_every_call(design):
    assert design_pid(PlantModel()) == design


def test_less_integral_action_gives_more_robustness(design):
    slower = design_pid(PlantModel(), integral_time=0.2)
    assert slower.gains.proportional / slower.gains.integral == pytest.approx(0.2)
    assert slower.margins.maximum_sensitivity < 0.92 * design.margins.maximum_sensitivity


def test_a_larger_phase_margin_costs_sensitivity(design):
    """17.4 degrees are more than the smallest M_s has: the demand is met, and just so."""
    wanted = math.radians(17.4)
    safer = design_pid(PlantModel(), phase_margin=wanted)
    assert safer.margins.smallest_phase_margin == pytest.approx(wanted, rel=0.01)
    assert safer.margins.smallest_phase_margin >= wanted
    assert safer.margins.maximum_sensitivity > design.margins.maximum_sensitivity + 0.02


def test_another_mechanism_and_another_bandwidth():
    stiff = PlantModel(structure=StructureParameters(stiffness=4e5, damping=200.0))
    design = design_pid(stiff, bandwidth=15.0, phase_margin=math.radians(30.0), control_rate=1000.0)
    assert design.margins.first_crossover == pytest.approx(15.0, rel=1e-9)
    assert design.margins.smallest_phase_margin >= math.radians(30.0)
    assert design.margins.stable
    assert design.sampled.stable
    assert design.control_rate == 1000.0
    # Far below the modes the motor is all there is: lead makes that loop as good as one likes.
    assert design.margins.maximum_sensitivity < 1.6


def test_a_demand_that_cannot_be_met_is_said_so():
    with pytest.raises(ValueError, match=r"^design_pid: no PID found with .* at least 60 degrees"):
        design_pid(PlantModel(), phase_margin=math.radians(60.0))


@pytest.mark.parametrize("name", ["bandwidth", "phase_margin", "integral_time", "control_rate"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_a_demand_that_is_no_positive_number_is_refused(name, value):
    with pytest.raises(ValueError, match=rf"^design_pid: {name} = .*: must be a positive number"):
        design_pid(PlantModel(), **{name: value})
