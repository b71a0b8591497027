"""Rows of running signals: few, and no extreme is lost."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_live.extremes import BUCKET, COLUMNS, PATIENCE, RowMaker, extremes

RATE = 5000


def telemetry(begin, count, seed=0):
    times = (begin + np.arange(count)) / RATE
    values = np.random.default_rng(seed + begin).normal(size=(count, 2))
    return np.column_stack([times, values])


def truth_of(rows, gap=0.1):
    times = rows[::10, 0]
    angles = np.column_stack([times, times, times - gap / 2, np.full(times.size, gap)])
    return np.column_stack([angles, np.zeros((times.size, 3))])


def column(rows, name):
    return [row[COLUMNS.index(name)] for row in rows]


@given(st.lists(st.floats(-1e6, 1e6), min_size=1))
def test_extremes_are_smallest_and_largest_in_their_order(values):
    first, second = extremes(np.array(values))
    assert {first, second} == {min(values), max(values)}
    assert values.index(first) <= values.index(second)


@given(batches=st.lists(st.integers(1, 400), min_size=5, max_size=30), seed=st.integers(0, 99))
def test_however_telemetry_is_batched_no_extreme_is_lost(batches, seed):
    maker, given_rows, made, begin = RowMaker(), [], [], 0
    for count in batches:
        batch = telemetry(begin, count, seed)
        maker.take_telemetry(batch)
        given_rows.append(batch)
        made += maker.rows()
        begin += count
    rows = np.concatenate(given_rows)
    buckets = np.floor(rows[:, 0] / BUCKET + 1e-6)
    assert len(made) == len(set(buckets)) - 1
    for row, number in zip(made, sorted(set(buckets)), strict=False):
        voltages = rows[buckets == number, 1]
        both = [row[COLUMNS.index(name)] for name in ("voltage_first", "voltage_second")]
        assert min(both) == pytest.approx(voltages.min(), rel=1e-6)
        assert max(both) == pytest.approx(voltages.max(), rel=1e-6)


def test_a_row_waits_for_its_truth():
    maker, rows = RowMaker(), telemetry(0, 400)
    maker.take_truth(truth_of(rows[:100]))
    maker.take_telemetry(rows)
    assert column(maker.rows(), "gap") == [0.1]
    maker.take_truth(truth_of(rows[100:]))
    assert column(maker.rows(), "gap") == [0.1] * 6


def test_without_truth_rows_of_a_real_machine_have_none():
    maker = RowMaker()
    maker.take_telemetry(telemetry(0, 400))
    rows = maker.rows()
    assert len(rows) == 7
    assert column(rows, "theta_m") == [None] * 7


def test_truth_that_stays_away_is_not_waited_for():
    maker, rows = RowMaker(), telemetry(0, RATE)
    maker.take_truth(truth_of(rows[:100]))
    maker.take_telemetry(rows)
    made = maker.rows()
    assert len(made) == 99
    assert column(made, "gap")[-1] is None
    assert PATIENCE < 0.99


def test_time_that_goes_back_begins_a_new_run():
    maker = RowMaker()
    maker.take_telemetry(telemetry(RATE, 400))
    maker.rows()
    maker.take_telemetry(telemetry(0, 400))
    assert column(maker.rows(), "time")[0] == 0.0


def test_what_holds_is_in_every_row_and_what_is_not_finite_is_not():
    maker = RowMaker()
    maker.hold("reference", 0.0, 5e-3)
    maker.hold("dead_zone", 0.0, float("nan"))
    maker.take_telemetry(telemetry(0, 400))
    rows = maker.rows()
    assert column(rows, "reference") == [5e-3] * 7
    assert column(rows, "dead_zone") == [None] * 7
    assert column(rows, "estimate") == [None] * 7


@pytest.mark.parametrize("batches", [1, 4])
def test_what_is_heard_before_its_samples_holds_from_its_own_time_on(batches):
    maker = RowMaker()
    maker.hold("reference", 0.0, 5e-3)
    maker.hold("reference", 0.04, 0.0)
    rows = []
    for batch in np.split(telemetry(0, 400), batches):
        maker.take_telemetry(batch)
        rows += maker.rows()
    assert column(rows, "reference") == [5e-3] * 4 + [0.0] * 3


def test_what_was_said_last_holds_when_time_begins_anew():
    maker = RowMaker()
    maker.hold("reference", 0.5, 5e-3)
    maker.take_telemetry(telemetry(RATE, 400))
    maker.rows()
    maker.hold("reference", 0.0, 1e-3)
    maker.take_telemetry(telemetry(0, 400))
    assert column(maker.rows(), "reference") == [1e-3] * 7
