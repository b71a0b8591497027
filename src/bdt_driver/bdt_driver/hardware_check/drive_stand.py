"""The stand on which a drive is checked: the drive, the limits, and how it is read and moved."""

import math
from collections.abc import Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from bdt_driver.driver_settings import DriveLimits, DriverSettings
from bdt_driver.guarded_drive import DriveError, GuardedDrive
from bdt_driver.hardware_check.record import Record
from bdt_driver.hardware_check.steady_clock import SteadyClock

CALL_TIMEOUT = 5.0
"""Time [s] after which a call counts as hanging, and a second thread stops the drive."""
REST_TIME = 2.0
"""Time [s] for which the machine is looked at while it rests."""
SETTLING_TIME = 0.5
"""Time [s] that the machine is given at least to come to rest."""
LONGEST_SETTLING = 5.0
"""Time [s] after which nobody waits any more for a machine that does not come to rest."""
QUIET_SHARE = 1e-3
"""Share of the travel within which a machine that rests stays."""
LONGEST_STROKE = 1.0
"""Longest time [s] for which a voltage is applied."""
STROKE_SHARE = 0.05
"""Share of the travel after which a stroke ends."""
EDGE_SHARE = 0.1
"""Share of the travel, at each of its ends, into which nothing is moved."""


class Motion(NamedTuple):
    """A stroke in each direction.

    Attributes
    ----------
    forward, backward : Record
        Readings while the positive and the negative voltage was applied.
    """

    forward: Record
    backward: Record


class DriveStand:
    """A drive that is checked.

    Parameters
    ----------
    options : mapping
        Arguments of the drive's class by name.
    settings : DriverSettings
        Class, rates and times.
    limits : DriveLimits
        Largest voltage that is applied, and the travel.
    clock : SteadyClock
        Time.
    """

    def __init__(
        self,
        options: Mapping[str, Any],
        settings: DriverSettings,
        limits: DriveLimits,
        clock: SteadyClock,
    ) -> None:
        self.options, self.settings, self.limits, self.clock = options, settings, limits, clock
        self._drive: GuardedDrive | None = None
        self._made: list[GuardedDrive] = []

    @property
    def period(self) -> float:
        """Control period [s]."""
        return 1.0 / self.settings.control_rate

    @property
    def travel(self) -> float:
        """Distance between the limits of the position [m]."""
        return self.limits.highest_position - self.limits.lowest_position

    @property
    def voltage(self) -> float:
        """Voltage with which the machine is moved [V]."""
        return self.limits.voltage

    @property
    def brings_samples(self) -> bool:
        """Whether the drive has a sampling clock of its own."""
        return self.settings.sampling_rate > 0.0

    @property
    def drive(self) -> GuardedDrive:
        """The drive that is checked."""
        if self._drive is None:
            self._drive = self.another_drive()
        return self._drive

    def another_drive(self, **changed: Any) -> GuardedDrive:
        """Return one more drive of the class, not open, with some arguments changed.

        Raises
        ------
        DriveError
            If there is no such class, or if it is no drive.
        """
        made = GuardedDrive(
            self.settings.driver,
            {**self.options, **changed},
            CALL_TIMEOUT,
            lambda _line: None,
            brings_samples=self.brings_samples,
        )
        self._made.append(made)
        return made

    def reopen(self) -> None:
        """Stop, close and open the drive; for a check after which nobody knows its state."""
        for call in (self.drive.stop, self.drive.close):
            try:
                call()
            except DriveError:
                # What is wrong with these has checks of its own.
                continue
        self.drive.open()

    def end(self) -> list[str]:
        """Stop and close the drive, and return what went wrong with that."""
        faults = []
        if self._drive is not None:
            for call in (self._drive.stop, self._drive.close):
                try:
                    call()
                except DriveError as error:
                    faults.append(str(error))
        for made in self._made:
            made.end()
        return faults

    def duration_of(self, call: Any, *arguments: Any) -> float:
        """Return how long a call lasts [s]."""
        began = self.clock.now()
        call(*arguments)
        return self.clock.now() - began

    # Reading -------------------------------------------------------------------------------

    def read_for(
        self, duration: float, voltage: float | None = None, *, until: float = math.inf
    ) -> Record:
        """Read at the control rate; ends early where the platform is about to leave its travel.

        Parameters
        ----------
        duration : float
            How long [s].
        voltage : float, optional
            Written before each reading [V]; None writes nothing.
        until : float
            Ends when the platform has moved so far [m].
        """
        record = Record()
        begin = self.clock.now()
        number = 0
        while (due := begin + number * self.period) < begin + duration:
            self.clock.sleep_until(due)
            if voltage is not None:
                self.drive.write(voltage)
            began = self.clock.now()
            reading = self.drive.read()
            ended = self.clock.now()
            record.began.append(began)
            record.ended.append(ended)
            record.readings.append(reading)
            if abs(record.change) >= until or self._is_leaving(reading.position, record.change):
                break
            number = max(number + 1, int((ended - begin) / self.period))
        return record

    def _is_leaving(self, position: float, change: float) -> bool:
        edge = EDGE_SHARE * self.travel
        low, high = self.limits.lowest_position, self.limits.highest_position
        # A platform that rests near an end may be moved away from it.
        towards_low = position < low + edge and change < -0.1 * edge
        towards_high = position > high - edge and change > 0.1 * edge
        return towards_low or towards_high

    @cached_property
    def at_rest(self) -> Record:
        """Readings of the machine at rest, before anything was written."""
        return self.read_for(REST_TIME)

    @cached_property
    def noise(self) -> float:
        """Standard deviation of the position at rest [m]."""
        return self.at_rest.noise()

    # Moving --------------------------------------------------------------------------------

    def stroke(self, voltage: float, duration: float = LONGEST_STROKE) -> Record:
        """Apply a voltage [V] until the platform has moved, and leave it applied."""
        return self.read_for(duration, voltage, until=STROKE_SHARE * self.travel)

    def settle(self) -> Record:
        """Take the voltage off and wait until the machine rests."""
        self.drive.write(0.0)
        self.drive.stop()
        return self.wait_for_rest()

    def wait_for_rest(self) -> Record:
        """Wait until the platform rests as it did at first, and return the last readings."""
        end = self.clock.now() + LONGEST_SETTLING
        quiet = max(QUIET_SHARE * self.travel, 10.0 * self.noise)
        while True:
            record = self.read_for(SETTLING_TIME)
            if float(np.ptp(record.positions)) <= quiet or self.clock.now() > end:
                return record

    def inward(self) -> float:
        """Return the voltage that strokes away from the nearer end of the travel [V].

        As the sign was found by the motion in both directions, which comes first.
        """
        middle = 0.5 * (self.limits.lowest_position + self.limits.highest_position)
        position = self.drive.read().position
        direction = math.copysign(1.0, self.motion.forward.change)
        return math.copysign(self.voltage, direction * (middle - position))

    @cached_property
    def motion(self) -> Motion:
        """A stroke in each direction, the first one away from the nearer end of the travel."""
        middle = 0.5 * (self.limits.lowest_position + self.limits.highest_position)
        first = math.copysign(self.voltage, middle - self.at_rest.readings[-1].position)
        records = {}
        for voltage in (first, -first):
            records[voltage > 0.0] = self.stroke(voltage)
            self.settle()
        return Motion(records[True], records[False])
