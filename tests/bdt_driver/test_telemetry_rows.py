"""Telemetry has a row for each sample, with the voltage that was in force from it on."""

import numpy as np
import pytest

from bdt_driver.drive import Reading
from bdt_driver.telemetry_rows import TelemetryRows


def test_the_voltage_of_a_row_is_the_one_that_was_applied_after_it():
    rows = TelemetryRows(1, 0.002)
    for number, (position, voltage) in enumerate([(1.0, 9.0), (2.0, 5.0), (3.0, 6.0)]):
        rows.add(number, 0.002 * number, Reading(position, voltage))
    assert len(rows) == 2
    (batch,) = rows.take()
    np.testing.assert_array_equal(batch, [[0.0, 5.0, 1.0], [0.002, 6.0, 2.0]])
    assert len(rows) == 0


def test_a_period_without_a_reading_leaves_a_hole_between_two_batches():
    rows = TelemetryRows(1, 0.002)
    for number in (0, 1, 2, 5, 6, 7):
        rows.add(number, 0.002 * number, Reading(0.1 * number, 1.0))
    before, after = rows.take()
    np.testing.assert_allclose(before[:, 0], [0.0, 0.002])
    np.testing.assert_allclose(after[:, 0], [0.01, 0.012])


def test_samples_that_a_reading_brings_end_at_its_time():
    rows = TelemetryRows(4, 0.0005)
    samples = np.arange(8.0).reshape(4, 2)
    rows.add(0, 1.0, Reading(7.0, 6.0, samples))
    rows.add(1, 1.002, Reading(7.0, 6.0, samples))
    (taken,) = rows.take()
    np.testing.assert_allclose(taken[:, 0], 1.0 + 0.0005 * np.arange(-3, 5))
    np.testing.assert_array_equal(taken[:, 1:], np.tile(samples, (2, 1)))


@pytest.mark.parametrize("samples", [np.zeros((3, 2)), np.zeros((4, 3)), np.zeros(8)])
def test_samples_that_are_not_those_of_the_period_are_refused(samples):
    rows = TelemetryRows(4, 0.0005)
    rows.add(0, 0.0, Reading(0.0, 0.0, np.zeros((4, 2))))
    with pytest.raises(ValueError, match=r"must be \(4, 2\), 4 for each control period"):
        rows.add(1, 0.002, Reading(0.0, 0.0, samples))


def test_a_reading_after_missed_periods_brings_their_samples_as_well():
    rows = TelemetryRows(4, 0.0005)
    rows.add(0, 0.0, Reading(0.0, 0.0, np.zeros((4, 2))))
    rows.add(3, 0.006, Reading(0.0, 0.0, np.zeros((12, 2))))
    (batch,) = rows.take()
    np.testing.assert_allclose(np.diff(batch[:, 0]), 0.0005)
