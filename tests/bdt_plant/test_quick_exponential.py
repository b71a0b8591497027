"""The quick exponential against the one that is right to the last bit."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bdt_plant.matrix_exponential import matrix_exponential
from bdt_plant.plant import PlantModel, discretize_plant
from bdt_plant.quick_exponential import quick_exponential


@given(arrays(np.float64, (4, 4), elements=st.floats(-3.0, 3.0)))
def test_any_matrix_of_moderate_size_has_its_exponential(matrix):
    expected = matrix_exponential(matrix)
    found = quick_exponential(matrix)
    assert np.abs(found - expected).max() <= 1e-13 * max(1.0, np.abs(expected).max())


@given(st.floats(-40.0, 40.0))
def test_of_a_number_it_is_the_exponential(number):
    assert quick_exponential(np.array([[number]]))[0, 0] == pytest.approx(np.exp(number), rel=1e-12)


@pytest.mark.parametrize("sample_time", [5e-5, 2e-4, 1e-3, 1e-2])
def test_the_plant_is_as_exact_as_floats_are(sample_time):
    exact = discretize_plant(PlantModel(), sample_time)
    quick = discretize_plant(PlantModel(), sample_time, quick_exponential)
    for name in ("motor", "structure"):
        expected = np.array(getattr(exact, name))
        found = np.array(getattr(quick, name))
        assert np.abs(found - expected).max() <= 1e-13 * np.abs(expected).max()
    # What the motor's curved path adds is a small difference of large numbers.
    off = np.abs(np.array(quick.contact) - np.array(exact.contact)).max()
    assert off <= 1e-13 * np.abs(np.array(exact.structure)).max()


def test_what_is_not_finite_is_refused():
    with pytest.raises(OverflowError, match="not finite"):
        quick_exponential(np.array([[0.0, np.nan], [0.0, 0.0]]))


def test_nothing_is_done_to_the_matrix():
    matrix = np.arange(9.0).reshape(3, 3)
    kept = matrix.copy()
    assert (quick_exponential(matrix.T) == quick_exponential(matrix.T.copy())).all()
    assert (matrix == kept).all()
