"""The choice of an estimator, one from outside this package included."""

import sys

import numpy as np
import pytest

from bdt_plant.plant import PlantModel
from bdt_twin.estimator_choice import EstimatorChoice, create_estimator
from bdt_twin.inverse_filter import InverseFilterEstimator, InverseFilterSettings
from bdt_twin.output_error import OutputErrorEstimator
from bdt_twin.output_error_settings import OutputErrorSettings

THIRD_PARTY = """
import math
from bdt_twin.estimator import Estimate


class Stubborn:
    def __init__(self, model, sampling_rate):
        assert model.lead_screw.pitch > 0.0
        assert sampling_rate == 1000.0

    def restart(self):
        pass

    def update(self, batch, *, newest_only=False):
        return Estimate(float(batch[-1, 0]), 0.25, uncertainty=math.radians(1.0))
"""


def create(kind, rate=5000.0):
    settings = InverseFilterSettings(sampling_rate=rate)
    fitting = OutputErrorSettings()
    return create_estimator(EstimatorChoice(kind), PlantModel(), settings, fitting)


def test_the_paper_s_estimator_is_the_default():
    assert EstimatorChoice().kind == "inverse_filter"
    assert isinstance(create("inverse_filter").estimator, InverseFilterEstimator)


def test_the_estimator_for_measured_signals_has_the_sampling_rate_of_the_telemetry():
    estimator = create("output_error", 1000.0)
    assert isinstance(estimator.estimator, OutputErrorEstimator)
    rows = np.column_stack([np.arange(100) / 1000.0, np.zeros((100, 2))])
    assert estimator.update(rows).reason


def test_one_file_adds_an_estimator(tmp_path, monkeypatch):
    (tmp_path / "stubborn_estimator.py").write_text(THIRD_PARTY)
    monkeypatch.syspath_prepend(tmp_path)
    estimator = create("stubborn_estimator:Stubborn", 1000.0)
    assert estimator.update(np.zeros((3, 3))).gap == 0.25
    sys.modules.pop("stubborn_estimator")


@pytest.mark.parametrize("kind", ["kalman", "", ":name", "module:"])
def test_a_choice_that_is_none_is_refused(kind):
    with pytest.raises(ValueError, match=r"EstimatorChoice\.kind = .*: must be one of inverse_fil"):
        EstimatorChoice(kind)


@pytest.mark.parametrize("kind", ["no_such_module:Estimator", "math:Estimator"])
def test_a_file_that_is_not_there_is_one_clear_line(kind):
    with pytest.raises(ValueError, match=f"^estimator.kind = '{kind}': .*(named|has no class)"):
        create(kind)
