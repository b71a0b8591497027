"""Theory beside simulation: where the describing function holds, and where not."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bdt_analysis.figures.figure_style import write_png
from bdt_controller.pid import PidGains
from bdt_plant.plant import PlantModel, Sampling
from bdt_study.limit_cycles.comparison import (
    compare_over_gap,
    compare_over_stiffness,
    limit_cycle_table,
    simulated_cycle,
)
from bdt_study.limit_cycles.figure import limit_cycle_figure
from bdt_study.limit_cycles.harmonic_balance import harmonic_balance_cycle

MODEL = PlantModel()
GAINS = PidGains(3080.0, 30800.0, -308.4, 0.074)
GAP = math.radians(10.0)


@pytest.fixture(scope="module")
def over_gap():
    return compare_over_gap(MODEL, GAINS, np.radians([2.5, 10.0]))


@pytest.fixture(scope="module")
def over_stiffness():
    return compare_over_stiffness(MODEL, GAINS, GAP, np.array([0.1, 0.8, 10.0]))


def test_the_simulated_limit_cycle_is_proportional_to_the_gap(over_gap):
    small, large = (each.simulation for each in over_gap)
    assert large.frequency == pytest.approx(small.frequency, rel=1e-9)
    assert large.peak_to_peak == pytest.approx(4 * small.peak_to_peak, rel=1e-9)


def test_the_third_harmonic_meets_the_first_mode(over_gap):
    simulated = over_gap[1].simulation
    assert 3 * simulated.frequency == pytest.approx(27.07, abs=0.1)
    assert simulated.third_harmonic == pytest.approx(0.450, abs=0.005)
    assert simulated.peak_to_peak == pytest.approx(149.0e-6, rel=0.01)


def test_the_describing_function_does_not_hold_for_table_1(over_gap):
    predicted, simulated = over_gap[1].describing_function, over_gap[1].simulation
    assert predicted.frequency / simulated.frequency == pytest.approx(0.937, abs=0.005)
    assert predicted.fundamental / simulated.fundamental == pytest.approx(0.816, abs=0.01)
    assert predicted.peak_to_peak / simulated.peak_to_peak == pytest.approx(0.605, abs=0.01)


def test_harmonic_balance_holds_for_table_1(over_gap):
    balanced, simulated = over_gap[1].harmonic_balance, over_gap[1].simulation
    assert balanced.frequency == pytest.approx(simulated.frequency, rel=2e-3)
    assert balanced.fundamental == pytest.approx(simulated.fundamental, rel=5e-3)
    assert balanced.peak_to_peak == pytest.approx(simulated.peak_to_peak, rel=5e-3)
    assert balanced.third_harmonic == pytest.approx(simulated.third_harmonic, rel=0.03)


def test_what_harmonic_balance_leaves_out_is_the_sampling_of_the_controller():
    fast = simulated_cycle(MODEL, GAINS, GAP, Sampling(control_rate=5000.0))
    balanced = harmonic_balance_cycle(MODEL, GAINS, GAP)
    assert balanced.frequency == pytest.approx(fast.frequency, rel=3e-4)
    assert balanced.fundamental == pytest.approx(fast.fundamental, rel=1e-3)
    assert balanced.peak_to_peak == pytest.approx(fast.peak_to_peak, rel=1e-3)


def test_the_describing_function_holds_for_a_stiff_structure(over_stiffness):
    stiff = over_stiffness[-1]
    assert stiff.stiffness == 1e5
    assert stiff.describing_function.frequency == pytest.approx(
        stiff.simulation.frequency, rel=0.01
    )
    assert stiff.describing_function.fundamental == pytest.approx(
        stiff.simulation.fundamental, rel=0.035
    )


def test_a_loop_that_is_unstable_without_backlash_is_left_out(over_stiffness):
    assert [each.stiffness for each in over_stiffness] == pytest.approx([8e3, 1e5])


def test_a_motion_that_comes_to_rest_is_no_limit_cycle():
    slow = PidGains(300.0, 0.0, 0.0, 0.1)
    assert simulated_cycle(MODEL, slow, GAP) is None


def test_an_oscillation_that_still_grows_is_no_limit_cycle():
    hot = replace(GAINS, proportional=1.8 * 3080.0, integral=1.8 * 30800.0, derivative=1.8 * -308.4)
    assert simulated_cycle(MODEL, hot, GAP, settling_time=2.0, observed_time=4.0) is None


def test_the_table_has_a_row_for_each_method_and_gap(over_gap):
    lines = limit_cycle_table(over_gap).splitlines()
    assert len(lines) == 2 + 3 * 2
    assert {line.count("|") for line in lines} == {7}
    assert lines[2].startswith("| 2.5 | describing function | 8.47 |")
    missing = (replace(over_gap[0], simulation=None),)
    assert limit_cycle_table(missing).splitlines()[-1].startswith("| 2.5 | simulation | none |")


def test_the_figure_is_drawn_also_where_a_method_finds_nothing(over_gap, over_stiffness, tmp_path):
    holes = (replace(over_gap[0], simulation=None), over_gap[1])
    figure = limit_cycle_figure(MODEL, holes, over_stiffness)
    write_png(figure, tmp_path / "limit_cycle.png", 40)
    size = figure.axes[0]
    drawn = {line.get_label(): line.get_ydata() for line in size.get_lines()}
    assert np.isnan(drawn["simulation"][0])
    assert drawn["simulation"][1] == pytest.approx(149.0, rel=0.01)
    assert (tmp_path / "limit_cycle.png").stat().st_size > 5000
