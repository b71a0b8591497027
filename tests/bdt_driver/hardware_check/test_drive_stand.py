"""The stand reads at the control rate and moves within limits."""

import math

import pytest
from checked_drives import Machine, Rail

from bdt_driver.driver_settings import DriveLimits, DriverSettings
from bdt_driver.hardware_check.drive_stand import EDGE_SHARE, STROKE_SHARE, DriveStand


@pytest.fixture
def stand():
    Machine.rail = Rail()
    settings = DriverSettings(driver="checked_drives:GoodDrive", sampling_rate=1000.0)
    limits = DriveLimits(voltage=2.0, lowest_position=-0.005, highest_position=0.005)
    made = DriveStand({}, settings, limits, Machine.rail.clock)
    made.drive.open()
    yield made
    made.end()


def test_it_reads_at_the_control_rate(stand):
    record = stand.read_for(0.1)
    assert len(record.readings) == 50
    assert record.began[-1] - record.began[0] == pytest.approx(49 * 0.002, abs=1e-6)


def test_a_stroke_ends_after_its_share_of_the_travel(stand):
    assert stand.stroke(2.0).change == pytest.approx(STROKE_SHARE * stand.travel, rel=0.05)


def test_a_stroke_towards_an_end_stops_before_it(stand):
    Machine.rail.position = Machine.rail.seen = 0.0039
    stand.wait_for_rest()
    record = stand.stroke(2.0)
    edge = 0.005 - EDGE_SHARE * stand.travel
    assert record.readings[-1].position == pytest.approx(edge + 0.1 * EDGE_SHARE * 0.01, abs=1e-4)


def test_out_of_the_edge_it_moves_freely(stand):
    Machine.rail.position = Machine.rail.seen = 0.0048
    stand.wait_for_rest()
    assert stand.stroke(-2.0).change == pytest.approx(-STROKE_SHARE * stand.travel, rel=0.05)


@pytest.mark.parametrize("position", [-0.003, 0.003])
def test_inward_is_towards_the_middle_whatever_the_sign_of_the_motor(stand, position):
    Machine.rail.moving = lambda voltage: -voltage
    assert stand.motion.forward.change < 0.0
    Machine.rail.position = position
    stand.wait_for_rest()
    assert math.copysign(1.0, stand.inward()) == math.copysign(1.0, position)


def test_it_waits_until_the_machine_rests(stand):
    assert stand.noise < 2e-6
    Machine.rail.creep = 0.001
    began = stand.clock.now()
    stand.wait_for_rest()
    assert stand.clock.now() - began > 5.0
