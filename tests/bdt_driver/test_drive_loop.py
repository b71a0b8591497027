"""The motor gets a voltage when the drive is armed, and in no other state."""

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule
from rail_drive import MADE, RailDrive, hang

from bdt_driver.drive_loop import DriveLoop, State
from bdt_driver.driver_settings import DriveLimits, DriverSettings
from bdt_driver.guarded_drive import DriveError, GuardedDrive

PERIOD = 0.002
SETTINGS = DriverSettings(driver="rail_drive:RailDrive", engage_time=0.2)
PATIENCE = 60.0
"""Time [s] that a call may last on the clock of this machine, which others keep busy, too."""


class Bench:
    """A drive on the bench: its loop, and the time."""

    def __init__(self, kind="rail_drive:RailDrive", limits=None, call_timeout=PATIENCE, **options):
        self.said = []
        guarded = GuardedDrive(kind, options, call_timeout, self.said.append)
        self.loop = DriveLoop(guarded, SETTINGS, limits or DriveLimits())
        self.drive = MADE[-1]
        self.guarded = guarded
        self.now = 100.0
        self.loop.open(self.now)

    def tick(self, periods=1):
        for _ in range(periods):
            self.now += PERIOD
            read = self.loop.tick(self.now)
        return read

    def run(self, voltage, periods):
        for _ in range(periods):
            self.tick()
            self.loop.command(voltage, self.now)


@pytest.fixture
def bench():
    bench = Bench()
    yield bench
    bench.guarded.end()


def test_at_first_it_is_disarmed_and_obeys_nothing(bench):
    bench.run(5.0, 10)
    assert bench.loop.state is State.OPEN
    assert bench.drive.written == []


def test_armed_it_obeys(bench):
    bench.tick()
    assert bench.loop.arm(bench.now) == ""
    bench.run(5.0, 200)
    assert bench.drive.voltage == bench.loop.voltage == 5.0
    assert bench.drive.position > 0.0


def test_without_a_reading_it_is_not_armed(bench):
    assert bench.loop.arm(bench.now) == "there is no reading yet"
    assert bench.loop.state is State.OPEN


def test_arming_an_armed_drive_changes_nothing(bench):
    bench.tick()
    bench.loop.arm(bench.now)
    bench.run(5.0, 200)
    assert bench.loop.arm(bench.now) == ""
    assert bench.drive.voltage == bench.loop.voltage == 5.0


def test_disarming_stops_at_once(bench):
    bench.tick()
    bench.loop.arm(bench.now)
    bench.run(5.0, 200)
    assert bench.loop.disarm(bench.now) == ""
    assert bench.drive.calls[-1] == "stop"
    assert (bench.loop.state, bench.drive.voltage) == (State.OPEN, 0.0)


def test_armed_again_it_begins_without_a_jump(bench):
    bench.tick()
    bench.loop.arm(bench.now)
    bench.run(20.0, 200)
    bench.loop.disarm(bench.now)
    bench.tick(50)
    bench.loop.arm(bench.now)
    bench.run(20.0, 1)
    assert 0.0 < bench.drive.voltage <= 0.01 * DriveLimits().voltage


def test_without_commands_the_voltage_is_gone_in_time_and_comes_back_without_a_jump(bench):
    bench.tick()
    bench.loop.arm(bench.now)
    bench.run(20.0, 200)
    silent_since = bench.now
    while bench.drive.voltage:
        bench.tick()
    assert bench.now - silent_since <= SETTINGS.command_timeout + 2 * PERIOD
    assert (bench.loop.state, bench.loop.silences) == (State.ARMED, 1)
    bench.run(20.0, 1)
    assert 0.0 < bench.drive.voltage <= 0.01 * DriveLimits().voltage


def test_beyond_the_travel_it_is_faulted(bench):
    bench.tick()
    bench.loop.arm(bench.now)
    bench.run(5.0, 200)
    bench.drive.position = 0.06
    bench.tick()
    assert bench.loop.state is State.FAULTED
    assert bench.loop.fault == "platform 3 is at 0.06004 m, beyond -0.05 m to 0.05 m"
    assert bench.drive.voltage == 0.0


def test_beyond_the_travel_it_is_not_armed(bench):
    bench.drive.position = -0.06
    bench.tick()
    assert "beyond -0.05 m to 0.05 m" in bench.loop.arm(bench.now)
    assert bench.loop.state is State.OPEN


@pytest.mark.parametrize("method", ["read", "write"])
def test_an_exception_of_the_drive_is_a_fault_with_its_place(bench, method):
    bench.tick()
    bench.loop.arm(bench.now)
    bench.run(5.0, 10)
    bench.drive.failing = method
    bench.run(5.0, 1)
    assert bench.loop.state is State.FAULTED
    assert bench.loop.fault.endswith(f"OSError: {method}: the cable is pulled")
    assert "rail_drive.py:" in bench.loop.fault
    assert bench.drive.voltage == 0.0


def test_a_drive_that_does_not_even_stop_says_so(bench):
    bench.tick()
    bench.loop.arm(bench.now)
    bench.run(5.0, 10)
    bench.drive.position, bench.drive.failing = 1.0, "stop"
    bench.tick()
    assert bench.loop.state is State.FAULTED
    assert "beyond" in bench.loop.fault
    assert "and it does not stop: " in bench.loop.fault


def test_a_faulted_drive_is_armed_after_it_was_disarmed(bench):
    bench.tick()
    bench.drive.failing = "read"
    bench.tick()
    assert "disarm it first" in bench.loop.arm(bench.now)
    assert "cable is pulled" in bench.loop.fault
    bench.drive.failing = ""
    assert bench.loop.disarm(bench.now) == ""
    assert bench.drive.calls[-2:] == ["close", "open"]
    bench.tick()
    assert bench.loop.arm(bench.now) == ""


def test_a_drive_that_does_not_open_again_stays_faulted(bench):
    bench.tick()
    bench.drive.failing = "read"
    bench.tick()
    bench.drive.failing = "open"
    assert "cable is pulled" in bench.loop.disarm(bench.now)
    assert bench.loop.state is State.FAULTED


def test_positions_that_are_no_numbers_are_a_fault_when_they_last():
    bench = Bench("rail_drive:LostSensor")
    bench.tick(40)
    assert (bench.loop.state, bench.loop.unreadable) == (State.OPEN, 40)
    bench.tick(20)
    assert bench.loop.state is State.FAULTED
    assert bench.loop.fault.startswith("no readable position for 0.1")
    bench.guarded.end()


def test_a_call_that_hangs_is_stopped_by_another_thread_and_told():
    bench = Bench(call_timeout=1.0)
    bench.tick()
    bench.loop.arm(bench.now)
    bench.run(5.0, 100)
    released = hang(bench.drive)
    bench.drive.stop = lambda: (RailDrive.stop(bench.drive), released.set())
    bench.guarded._stop = bench.drive.stop
    bench.tick()
    assert bench.said == ["read lasts longer than 1 s: stopped"]
    assert bench.loop.state is State.FAULTED
    assert bench.loop.fault.endswith("read lasts longer than 1 s: stopped")
    assert bench.drive.voltage == 0.0
    bench.guarded.end()


def test_a_closed_drive_is_stopped_before(bench):
    bench.tick()
    bench.loop.close()
    assert bench.drive.calls[-2:] == ["stop", "close"]
    assert bench.loop.state is State.CLOSED
    assert bench.loop.arm(bench.now) == "the drive is closed"
    assert bench.tick() is None


def test_a_drive_that_does_not_open_is_closed(bench):
    bench.loop.close()
    bench.drive.failing = "open"
    with pytest.raises(DriveError, match="cable is pulled"):
        bench.loop.open(bench.now)
    assert bench.drive.calls[-2:] == ["open", "close"]
    assert bench.loop.state is State.CLOSED


def test_what_does_not_stop_is_closed_all_the_same(bench):
    bench.tick()
    bench.drive.failing = "stop"
    with pytest.raises(DriveError, match="cable is pulled"):
        bench.loop.close()
    assert bench.drive.calls[-1] == "close"


class AnyOrder(RuleBasedStateMachine):
    """Whatever comes in whatever order, an unarmed drive is without voltage."""

    def __init__(self):
        super().__init__()
        self.bench = Bench()

    @rule(periods=st.integers(1, 100))
    def wait(self, periods):
        self.bench.tick(periods)

    @rule(voltage=st.floats(-100.0, 100.0), periods=st.integers(1, 30))
    def command(self, voltage, periods):
        self.bench.run(voltage, periods)

    @rule()
    def arm(self):
        self.bench.loop.arm(self.bench.now)

    @rule()
    def disarm(self):
        self.bench.loop.disarm(self.bench.now)

    @rule(method=st.sampled_from(["", "read", "write", "open", "close"]))
    def fail(self, method):
        self.bench.drive.failing = method

    @rule(position=st.floats(-0.06, 0.06))
    def carry(self, position):
        self.bench.drive.position = position

    @invariant()
    def only_an_armed_motor_has_a_voltage(self):
        loop, drive = self.bench.loop, self.bench.drive
        assert drive.voltage == loop.voltage or drive.failing == "write"
        assert loop.state is State.ARMED or drive.voltage == 0.0
        assert bool(loop.fault) == (loop.state is State.FAULTED)
        assert abs(drive.voltage) <= DriveLimits().voltage

    def teardown(self):
        self.bench.guarded.end()


AnyOrder.TestCase.settings = settings(max_examples=40, stateful_step_count=30, deadline=None)
test_any_order = AnyOrder.TestCase
