"""The serial drive and the emulator keep the contract with the driver, in real time."""

import pytest

from bdt_driver.driver_settings import DriveLimits, DriverSettings
from bdt_driver.hardware_check.check import Outcome
from bdt_driver.hardware_check.drive_stand import DriveStand
from bdt_driver.hardware_check.runner import run_checks
from bdt_driver.hardware_check.steady_clock import ComputerClock

pytestmark = pytest.mark.real_time

OF_THE_COMPUTER = {
    "follows",
    "is_never_late",
    "keeps_rate",
    "reads_quickly",
    "samples_without_steps",
    "stops",
    "stops_quickly",
    "survives_silent",
    "tells_in_time",
    "writes_quickly",
}
"""What a machine that is busy with other tests may fail; `make hardware` looks at these, too."""


def test_all_is_kept_but_for_what_a_busy_computer_does(emulate):
    settings = DriverSettings(
        driver="bdt_drive_emulator.emulated_drive:EmulatedDrive", sampling_rate=5000.0
    )
    limits = DriveLimits(voltage=4.0, lowest_position=-0.005, highest_position=0.005)
    stand = DriveStand({"port": emulate()}, settings, limits, ComputerClock())
    try:
        results = list(run_checks(stand, may_move=True))
    finally:
        faults = stand.end()
    failed = {x.check.name: x.text for x in results if x.outcome is Outcome.FAILED}
    assert set(failed) <= OF_THE_COMPUTER, failed
    assert [x.check.name for x in results if x.outcome is Outcome.SKIPPED] == []
    assert faults == []
