"""The benchmark of fleets: what counts as borne, the search, and one small fleet of processes."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_study.benchmarks import twins
from bdt_study.benchmarks.bench import run_benchmarks
from bdt_study.benchmarks.result import BenchmarkSize
from bdt_study.benchmarks.twins import Trial, largest_borne, trial

pytestmark = pytest.mark.real_time


@pytest.mark.parametrize(
    ("lags", "estimates", "expected"),
    [
        ([0.1, 1.0], [10, 8], True),
        ([0.1, 1.1], [10, 10], False),
        ([0.1, 0.1], [10, 7], False),
    ],
)
def test_a_fleet_is_borne_if_each_twin_keeps_up(lags, estimates, expected):
    assert Trial(10.0, lags, estimates).is_borne is expected


@given(st.integers(0, 2 * twins.MOST))
def test_the_search_finds_what_is_borne_to_a_quarter(true):
    found = largest_borne(lambda machines: machines <= true)
    assert found <= true
    assert found >= min(true, twins.MOST // 2) / 1.25 - 1


def test_an_overloaded_fleet_is_told_beside_its_luckiest_twin(monkeypatch):
    def pretend(machines, duration):
        behind = machines > 16
        return Trial(duration, [3.0, 4.0] if behind else [0.1], [5, 10] if behind else [15])

    monkeypatch.setattr(twins, "trial", pretend)
    results = run_benchmarks(["twins"], BenchmarkSize(twins_duration=15.0))["results"]
    assert [(one["value"], one["reference_value"]) for one in results] == [
        (16.0, None),
        (3.5, 4.0),
        (5.0, 10.0),
    ]
    assert "of 24 twins" in results[1]["reference"]


def test_a_small_fleet_is_heard():
    said = trial(1, 2.5, warm_up=0.1)
    # How far it is behind is a matter of what else the computer does.
    assert len(said.lags) == len(said.estimates) == 1
