"""Each check fails for a drive that breaks its point, and for no other one."""

import math

import checked_drives
import pytest
from checked_drives import Machine, Rail, broken_at

from bdt_driver.driver_settings import DriveLimits, DriverSettings
from bdt_driver.hardware_check.check import Outcome
from bdt_driver.hardware_check.drive_stand import DriveStand
from bdt_driver.hardware_check.runner import CHECKS, run_checks

LIMITS = DriveLimits(voltage=2.0, lowest_position=-0.005, highest_position=0.005)


def results_of(name, *, may_move=True, sampling_rate=1000.0, options=None, **run):
    Machine.rail = Rail()
    settings = DriverSettings(
        driver=f"checked_drives:{name}", sampling_rate=sampling_rate, command_timeout=0.02
    )
    stand = DriveStand(options or {}, settings, LIMITS, Machine.rail.clock)
    try:
        return {result.check.name: result for result in run_checks(stand, may_move=may_move, **run)}
    finally:
        stand.end()


def names_of(results, outcome):
    return {name for name, result in results.items() if result.outcome is outcome}


def texts(results):
    return {name: result.text for name, result in results.items() if result.outcome != "ok"}


def test_there_are_more_than_twenty_five_each_with_a_name_a_reason_and_advice():
    assert len(CHECKS) > 25
    assert len({check.name for check in CHECKS}) == len(CHECKS)
    assert all(check.reason.endswith(".") and check.advice.endswith(".") for check in CHECKS)


def test_each_comes_behind_what_it_needs():
    before = set()
    for check in CHECKS:
        assert before.issuperset(check.needs), check.name
        before.add(check.name)


def test_a_drive_that_keeps_the_contract_passes_all():
    results = results_of("GoodDrive")
    assert texts(results) == {}
    assert len(results) == len(CHECKS)


@pytest.mark.parametrize("check", [check.name for check in CHECKS])
def test_a_drive_that_breaks_one_point_fails_at_that_one(check):
    # A check without such a class in checked_drives is an AttributeError here.
    assert getattr(checked_drives, broken_at(check))
    results = results_of(broken_at(check))
    assert names_of(results, Outcome.FAILED) == {check}, texts(results)


def test_without_consent_nothing_is_written():
    written = []

    class Watched(checked_drives.GoodDrive):
        def write(self, voltage):
            written.append(voltage)

    checked_drives.Watched = Watched
    try:
        results = results_of("Watched", may_move=False)
    finally:
        del checked_drives.Watched
    assert written == []
    moving = {check.name for check in CHECKS if check.moves}
    assert names_of(results, Outcome.SKIPPED) == moving


def test_voltage_and_travel_stay_within_the_limits():
    largest = []

    class Watched(checked_drives.GoodDrive):
        def write(self, voltage):
            largest.append((abs(voltage), abs(self.rail.position)))
            super().write(voltage)

    checked_drives.Watched = Watched
    try:
        results_of("Watched")
    finally:
        del checked_drives.Watched
    voltages = [voltage for voltage, _ in largest if math.isfinite(voltage)]
    assert max(voltages) == LIMITS.voltage
    assert max(position for _, position in largest) < LIMITS.highest_position


def test_a_drive_that_samples_when_it_is_read_skips_what_is_about_samples():
    results = results_of("GoodDrive", sampling_rate=0.0)
    assert names_of(results, Outcome.FAILED) == set()
    assert names_of(results, Outcome.SKIPPED) == {
        "tells_newest",
        "samples_at_rate",
        "samples_without_steps",
        "loses_nothing",
    }


def test_a_call_that_does_not_return_ends_the_checks(monkeypatch):
    from threading import Event

    never = Event()
    monkeypatch.setattr(checked_drives.GoodDrive, "read", lambda self: never.wait())
    results = results_of("GoodDrive", hanging=0.2)
    never.set()
    assert results["reads"].text == "a call of the drive has not returned for 0.2 s"
    assert results["reads"].outcome is Outcome.FAILED
    assert results["stops"].text == "reads has not come to an end"


def test_a_drive_that_does_not_come_back_after_a_fault_is_told():
    class Once(checked_drives.Reads):
        def open(self):
            if self.was_open:
                raise OSError("no more")
            super().open()

    checked_drives.Once = Once
    try:
        results = results_of("Once")
    finally:
        del checked_drives.Once
    assert "and does not open again: " in results["reads"].text
    assert names_of(results, Outcome.FAILED) == {"reads"}
