"""Somebody's drive is found, and what is wrong with it is told in a line with its place."""

import numpy as np
import pytest
from rail_drive import MADE

from bdt_driver.guarded_drive import DriveError, GuardedDrive


def create(kind, **options):
    drive = GuardedDrive(kind, options, 0.1, lambda line: None)
    drive.end()
    return drive


def test_the_class_gets_its_parameters():
    create("rail_drive:RailDrive", samples=4)
    assert MADE[-1].per_period == 4


@pytest.mark.parametrize(
    ("kind", "options", "message"),
    [
        ("no_such_module:Drive", {}, "No module named 'no_such_module'"),
        ("rail_drive:RailDrives", {}, "has no class RailDrives; did you mean RailDrive?"),
        ("rail_drive:RailDrive", {"port": 1}, "RailDrive: does not take drive.port"),
        ("rail_drive:NoStop", {}, r"NoStop: has no method stop\(\)"),
        ("rail_drive:SPEED", {}, "has no class SPEED"),
    ],
)
def test_what_is_no_drive_is_refused_in_a_line(kind, options, message):
    with pytest.raises(DriveError, match=message) as caught:
        create(kind, **options)
    assert "\n" not in str(caught.value)


def test_a_call_that_was_stopped_as_it_returned_is_told_by_the_next_one():
    """The second thread may find a call late in the very moment of its end."""
    drive = create("rail_drive:RailDrive")
    drive._late = "read lasts longer than 0.1 s: stopped"
    with pytest.raises(DriveError, match="read lasts longer"):
        drive.write(1.0)
    drive.write(1.0)


def test_a_late_call_that_fails_tells_its_own_fault_and_no_other():
    drive = create("rail_drive:RailDrive")
    MADE[-1].failing = "read"
    drive._late = "read lasts longer than 0.1 s: stopped"
    with pytest.raises(DriveError, match="the cable is pulled"):
        drive.read()
    drive.stop()


@pytest.mark.parametrize("found", [None, 1.0, (1.0,), ("a", 1.0), (1.0, 2.0, None, "x")])
def test_a_reading_that_is_none_is_a_fault(found):
    drive = create("rail_drive:RailDrive")
    drive._read = lambda: found
    with pytest.raises(DriveError, match="must be position, voltage and samples if any"):
        drive.read()


@pytest.mark.parametrize(
    "samples", [np.zeros((4, 3)), np.zeros(8), np.full((4, 2), np.nan), None, "samples", 1.0]
)
def test_what_are_no_samples_is_a_fault(samples):
    drive = GuardedDrive("rail_drive:RailDrive", {}, 0.1, lambda line: None, brings_samples=True)
    drive.end()
    drive._read = lambda: (0.0, 0.0, samples)
    with pytest.raises(DriveError, match=r"must be \(n, 2\), voltages and positions, finite"):
        drive.read()
