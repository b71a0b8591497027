"""Telemetry has a row for each sample, with the voltage that was in force from it on."""

import numpy as np
import pytest

from bdt_driver.drive import Reading
from bdt_driver.telemetry_rows import SampledByHardware, SampledWhenRead, TelemetryRows

SAMPLES = np.arange(8.0).reshape(4, 2)


def test_the_voltage_of_a_row_is_the_one_that_was_applied_after_it():
    rows = TelemetryRows()
    drive = SampledWhenRead(rows)
    for number, (position, voltage) in enumerate([(1.0, 9.0), (2.0, 5.0), (3.0, 6.0)]):
        assert drive.add(number, 0.002 * number, Reading(position, voltage)) == 0.002 * number
    assert len(rows) == 2
    (batch,) = rows.take()
    np.testing.assert_array_equal(batch, [[0.0, 5.0, 1.0], [0.002, 6.0, 2.0]])
    assert len(rows) == 0


def test_a_period_without_a_reading_leaves_a_hole_between_two_batches():
    rows = TelemetryRows()
    drive = SampledWhenRead(rows)
    for number in (0, 1, 2, 5, 6, 7):
        drive.add(number, 0.002 * number, Reading(0.1 * number, 1.0))
    before, after = rows.take()
    np.testing.assert_allclose(before[:, 0], [0.0, 0.002])
    np.testing.assert_allclose(after[:, 0], [0.01, 0.012])


def test_samples_of_the_hardware_go_on_from_reading_to_reading():
    rows = TelemetryRows()
    drive = SampledByHardware(rows, 2000.0)
    assert drive.add(0, 1.0, Reading(7.0, 6.0, SAMPLES)) == 1.0
    assert drive.add(1, 1.002, Reading(7.0, 6.0, SAMPLES)) == pytest.approx(1.002)
    (batch,) = rows.take()
    np.testing.assert_allclose(batch[:, 0], 1.0 + 0.0005 * np.arange(-3, 5))
    np.testing.assert_array_equal(batch[:, 1:], np.tile(SAMPLES, (2, 1)))


def test_lost_samples_leave_a_hole_of_their_length():
    rows = TelemetryRows()
    drive = SampledByHardware(rows, 2000.0)
    drive.add(0, 1.0, Reading(7.0, 6.0, SAMPLES))
    drive.add(1, 1.004, Reading(7.0, 6.0, SAMPLES, lost=4))
    before, after = rows.take()
    assert after[0, 0] - before[-1, 0] == pytest.approx(0.0025)


def test_no_sample_yet_is_no_row():
    rows = TelemetryRows()
    drive = SampledByHardware(rows, 2000.0)
    assert drive.add(0, 1.0, Reading(7.0, 6.0, np.empty((0, 2)))) is None
    assert len(rows) == 0
