"""A position stuck at its extreme while the motor turns."""

import numpy as np
import pytest

from bdt_twin.sensor_saturation import SHORTEST_SATURATION, motor_travel_in_saturation


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_turn_during_the_longest_run_counts(sign):
    position = sign * np.minimum(np.arange(200.0), 100.0)
    voltage = np.ones(200)
    assert motor_travel_in_saturation(voltage, position, 0.1) == pytest.approx(9.9)


def test_a_motor_at_rest_is_not_stuck():
    voltage = np.zeros(200)
    assert motor_travel_in_saturation(voltage, np.minimum(np.arange(200.0), 100.0), 0.1) == 0.0


def test_short_runs_are_peaks():
    position = np.minimum(np.arange(200.0), 200.0 - SHORTEST_SATURATION + 1)
    assert motor_travel_in_saturation(np.ones(200), position, 0.1) == 0.0
