"""The states of a drive and what happens in each: reading, commands, silence, faults."""

from enum import StrEnum
from typing import NamedTuple, Never

from bdt_driver.drive import Reading
from bdt_driver.driver_settings import DriveLimits, DriverSettings
from bdt_driver.guarded_drive import DriveError, GuardedDrive, is_readable
from bdt_driver.sample_clock import SampleClock
from bdt_driver.voltage_guard import VoltageGuard


class State(StrEnum):
    """State of a drive; the motor gets a voltage when it is armed, and in no other state."""

    CLOSED = "closed"
    OPEN = "open"
    ARMED = "armed"
    FAULTED = "faulted"


class NumberedReading(NamedTuple):
    """A reading, the number of its control period, and its time since the first one [ns]."""

    number: int
    nanoseconds: int
    reading: Reading


class DriveLoop:
    """Reads a drive, applies commands within the limits, and stops when something is wrong.

    Parameters
    ----------
    drive : GuardedDrive
        The drive, not yet open.
    settings : DriverSettings
        Rates and times.
    limits : DriveLimits
        What the motor may get, and where platform 3 may be.

    Attributes
    ----------
    state : State
        ``closed`` at first.
    fault : str
        Why the drive is faulted; empty when it is not.
    unreadable : int
        Number of readings that were not numbers.
    silences : int
        How often commands failed to come while the drive was armed.
    """

    def __init__(self, drive: GuardedDrive, settings: DriverSettings, limits: DriveLimits) -> None:
        self._drive = drive
        self._settings = settings
        self._limits = limits
        self._guard = VoltageGuard(limits, settings.engage_time)
        self._clock = SampleClock(settings.control_rate)
        self.state = State.CLOSED
        self.fault = ""
        self.unreadable = self.silences = 0
        self._newest: Reading | None = None
        self._read_at = self._commanded_at = 0.0
        self._is_engaged = False

    @property
    def voltage(self) -> float:
        """Voltage in force [V]."""
        return self._guard.applied

    @property
    def is_engaged(self) -> bool:
        """Whether commands come and are applied."""
        return self._is_engaged

    @property
    def missed(self) -> int:
        """Number of control periods without a reading."""
        return self._clock.missed

    @property
    def limited(self) -> int:
        """Number of commands that were beyond a limit."""
        return self._guard.limited

    # Transitions ---------------------------------------------------------------------------

    def open(self, now: float) -> None:
        """Connect to a closed drive; `now` is the steady time [s], here and below.

        Raises
        ------
        DriveError
            If the drive does not open; it is closed again.
        """
        try:
            self._drive.open()
        except DriveError as error:
            self._close_after(error)
        self.state, self.fault = State.OPEN, ""
        self._newest, self._read_at = None, now

    def arm(self, now: float) -> str:
        """Let commands through; an armed drive stays as it is.

        Returns
        -------
        str
            Why not; empty when the drive is armed.
        """
        if self.state is State.ARMED:
            return ""
        if self.state is State.FAULTED:
            return f"the drive is faulted ({self.fault}): disarm it first"
        if self.state is State.CLOSED:
            return "the drive is closed"
        if self._newest is None or not is_readable(self._newest):
            return "there is no reading yet"
        if not self._limits.allow(self._newest.position):
            return self._travel()
        self._rest()
        self.state, self._commanded_at = State.ARMED, now
        return ""

    def disarm(self, now: float) -> str:
        """Take the voltage away; a faulted drive is closed and opened again.

        Returns
        -------
        str
            Why the drive could not be brought back; empty when it is open.
        """
        try:
            if self.state is State.FAULTED:
                self._drive.close()
                self.open(now)
            else:
                self.state = State.OPEN
                self._stop()
        except DriveError as error:
            self._fail(str(error))
        return self.fault

    def close(self) -> None:
        """Stop and disconnect, whatever the state; for the end of the node.

        Raises
        ------
        DriveError
            If the drive does not stop or does not close; it is told to do both.
        """
        if self.state is State.CLOSED:
            return
        self.state = State.CLOSED
        try:
            self._stop()
        finally:
            self._drive.close()

    def _close_after(self, fault: DriveError) -> Never:
        try:
            self._drive.close()
        except DriveError as error:
            raise DriveError(f"{fault}; and it does not close: {error}") from fault
        raise fault

    # Every period --------------------------------------------------------------------------

    def tick(self, now: float) -> NumberedReading | None:
        """Read the drive, and look whether it is well.

        Returns
        -------
        NumberedReading or None
            None when nothing is due or nothing could be read.
        """
        if self.state not in (State.OPEN, State.ARMED):
            return None
        number = self._clock.tick(now)
        if number is None:
            return None
        try:
            reading = self._drive.read()
            if not is_readable(reading):
                self.unreadable += 1
                if now - self._read_at > self._settings.command_timeout:
                    self._fail(f"no readable position for {now - self._read_at:.3g} s")
                return None
            if reading.samples is None or len(reading.samples):
                self._read_at = now
            elif now - self._read_at > self._settings.command_timeout:
                self._fail(f"no sample for {now - self._read_at:.3g} s")
                return None
            self._newest = reading
            if self.state is State.ARMED:
                self._watch(reading, now)
        except DriveError as error:
            self._fail(str(error))
            return None
        return NumberedReading(number, self._clock.nanoseconds(number), reading)

    def command(self, voltage: float, now: float) -> None:
        """Apply a commanded voltage [V]; without effect when the drive is not armed."""
        if self.state is not State.ARMED:
            return
        period = 1.0 / self._settings.control_rate
        if self._is_engaged:
            # No more than a period for one that came late: the limit of the rate holds for both.
            period = min(now - self._commanded_at, period)
        self._is_engaged, self._commanded_at = True, now
        try:
            self._drive.write(self._guard.voltage(voltage, period))
        except DriveError as error:
            self._fail(str(error))

    def _fail(self, reason: str) -> None:
        """Stop because of a fault; a drive that cannot even do that says so, too."""
        self.state, self.fault = State.FAULTED, reason
        try:
            self._stop()
        except DriveError as error:
            self.fault = f"{reason}; and it does not stop: {error}"

    def _watch(self, reading: Reading, now: float) -> None:
        if not self._limits.allow(reading.position):
            self._fail(self._travel())
        elif self._is_engaged and now - self._commanded_at > self._settings.command_timeout:
            self.silences += 1
            self._stop()

    def _travel(self) -> str:
        position = self._newest.position if self._newest else float("nan")
        return (
            f"platform 3 is at {position:g} m, beyond {self._limits.lowest_position:g} m to "
            f"{self._limits.highest_position:g} m"
        )

    def _rest(self) -> None:
        self._guard.rest()
        self._is_engaged = False

    def _stop(self) -> None:
        self._rest()
        self._drive.stop()
