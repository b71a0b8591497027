"""Where steps begin and end, and which of them can be judged."""

import numpy as np
import pytest

from bdt_analysis.metrics.reference_steps import find_steps

DT = 0.01


def telemetry(begin: float, end: float, position: float = 0.0) -> np.ndarray:
    time = np.arange(round(begin / DT), round(end / DT)) * DT
    return np.stack([time, 0 * time, 0 * time + position], axis=1)


def steps_of(reference, begin: float, end: float, position: float = 0.0):
    return find_steps(np.array(reference).reshape(-1, 2), telemetry(begin, end, position), DT)


def test_square_wave():
    steps = steps_of([(0, 5e-3), (10, 0), (20, 5e-3)], 0, 30)
    assert [step.t_start for step in steps] == [0, 10, 20]
    assert [step.t_end for step in steps] == pytest.approx([10, 20, 30])
    assert [step.height for step in steps] == [5e-3] * 3
    assert [step.window for step in steps] == pytest.approx([3, 3, 3])
    assert not any(step.cut for step in steps)


def test_a_ramp_is_one_step_that_is_judged_where_it_has_arrived():
    ramp = [(10 + 0.01 * k, 1e-3 * k) for k in range(201)]
    steps = steps_of([(0, 0.0), *ramp, (16, 0.1)], 0, 26)
    assert [step.t_start for step in steps] == pytest.approx([0, 10.01, 16])
    assert [step.reference for step in steps] == pytest.approx([0.0, 0.2, 0.1])
    assert [step.height for step in steps[1:]] == pytest.approx([0.2, 0.1])
    assert [step.window for step in steps] == pytest.approx([3.0, 2.0, 3.0])


def test_a_ramp_that_the_recording_cuts_is_not_judged():
    ramp = [(10 + 0.01 * k, 1e-3 * k) for k in range(201)]
    last = steps_of([(0, 0.0), *ramp], 0, 11)[-1]
    assert (last.window, last.cut) == (0.0, True)


def test_first_height_is_the_distance_from_the_first_position():
    assert steps_of([(0, 5e-3)], 0, 10, 1e-3)[0].height == pytest.approx(4e-3)


def test_repeated_reference_is_no_step():
    steps = steps_of([(0, 1.0), (2, 1.0), (5, 2.0), (5, 3.0)], 0, 10)
    assert [(step.t_start, step.reference) for step in steps] == [(0, 1.0), (5, 3.0)]


def test_short_steps_are_judged_on_their_last_half():
    steps = steps_of([(0, 1.0), (2, 0.0), (4, 1.0)], 0, 6)
    assert [step.window for step in steps] == pytest.approx([1.0, 1.0, 1.0])


@pytest.mark.parametrize(("end", "cut"), [(20.0, False), (16.0, False), (15.9, True), (10.5, True)])
def test_last_step_cut_by_the_end(end: float, cut: bool):
    assert [step.cut for step in steps_of([(0, 1.0), (10, 0.0)], 0, end)] == [False, cut]


def test_a_single_step_is_never_cut():
    assert [step.cut for step in steps_of([(0, 1.0)], 0, 2)] == [False]


def test_step_that_began_before_the_recording():
    first, second = steps_of([(0, 1.0), (10, 0.0)], 5, 20, position=1.0)
    assert first.t_start == 0
    assert first.height is None
    assert first.scale == second.height == 1.0


def test_step_that_changes_nothing_has_no_height():
    first, second = steps_of([(0, 0.0), (10, 5e-3)], 0, 20, position=1e-9)
    assert first.height is None
    assert first.scale == second.height == 5e-3


def test_references_outside_the_telemetry():
    steps = steps_of([(0, 1.0), (5, 2.0), (50, 3.0)], 6, 20)
    assert [step.reference for step in steps] == [2.0]
    assert steps_of([(50, 1.0)], 0, 20) == []
    assert steps_of([], 0, 20) == []
