"""The machine that windows tell of, whatever clock the telemetry has been sampled with."""

import math

import numpy as np
import pytest
from recorded_machine import Run, record
from unknown_machine import UnknownMachine

from bdt_plant.plant import PlantModel
from bdt_study.calibration.fitted_data import Data
from bdt_study.calibration.followed_windows import follow_windows
from bdt_twin.stretch import Stretch

GAP = math.radians(12.0)


@pytest.fixture(scope="module")
def rows():
    run = Run(12.0, sampling_rate=1000.0, first_gap=GAP, last_gap=GAP)
    return record(UnknownMachine(), run).rows


@pytest.mark.parametrize("rate", [1000.0, 1000.596, 999.0 + 1.0 / 3.0])
def test_the_gap_is_that_of_the_machine_although_no_second_is_whole_samples(rows, rate):
    data = Data([Stretch(0, rows[:, 1], rows[:, 2])], rate)
    followed = follow_windows(PlantModel(), data)
    assert followed.gaps[-1] == pytest.approx(GAP, abs=math.radians(0.3))
    assert 8.0 < followed.times[-1] < 12.1
    assert (np.diff(followed.times) > 0.0).all()
