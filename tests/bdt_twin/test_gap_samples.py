"""The gap at the samples is the straight line between the knots."""

import numpy as np
import pytest

from bdt_twin.gap_samples import GapSamples
from bdt_twin.stretch import Stretch

RATE = 1000.0


@pytest.mark.parametrize(("first", "count"), [(2000, 4000), (2345, 1200), (3999, 2), (2100, 50)])
@pytest.mark.parametrize("spacing", [1.0, 0.3])
def test_it_is_what_numpy_interpolates(first, count, spacing):
    begin, end = first / RATE, (first + count) / RATE
    knots = spacing * np.arange(np.floor(begin / spacing), np.ceil(end / spacing) + 1.0)
    gaps = np.random.default_rng(first).uniform(0.0, 0.3, knots.size)
    stretch = Stretch(first, np.zeros(count), np.zeros(count))
    times = (first + np.arange(count)) / RATE
    found = GapSamples(knots, stretch, RATE).at(gaps)
    assert found == pytest.approx(np.interp(times, knots, gaps), abs=1e-12)
