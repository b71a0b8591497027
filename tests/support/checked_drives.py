"""A drive that keeps the contract, and for each check one that breaks just that point of it.

They drive a carriage on a rail, in the time of a clock that passes when it is waited for.
"""

import math
import random
import threading

SPEED = 0.001
"""Speed of the carriage [m/s] at 1 V."""
RATE = 1000.0
"""Samples per second [Hz]."""
WATCHDOG = 0.1
PORT = "/dev/rail"


class VirtualClock:
    """Time that passes when somebody waits or a call takes some."""

    def __init__(self):
        self.time, self.oversleep = 0.0, 0.0

    def now(self):
        return self.time

    def sleep_until(self, due):
        self.time = max(due + self.oversleep, self.time)

    def take(self, duration):
        self.time += duration


class Rail:
    """The machine: amplifier with watchdog, carriage, sensor with a clock of its own."""

    def __init__(self):
        self.clock = VirtualClock()
        self.position = self.seen = self.voltage = self.creep = self.drift = 0.0
        self.noise, self.rate, self.watchdog = 1e-6, RATE, WATCHDOG
        self.written_at, self.owner, self.sample = -math.inf, None, 0
        self.fault, self.fault_end, self.passed = "", -math.inf, []
        self.random = random.Random(1)  # noqa: S311 - nothing secret

    def has(self, fault):
        return self.fault == fault and self.clock.time < self.fault_end

    def advance(self):
        """Let the carriage move until now."""
        while (self.sample + 1) / self.rate <= self.clock.time:
            self.sample += 1
            time = self.sample / self.rate
            if time - self.written_at > self.watchdog:
                self.voltage = 0.0
            self.position += (self.moving(self.voltage) * SPEED + self.creep) / self.rate
            seen = self.position + self.drift * min(time, 2.0) + self.random.gauss(0.0, self.noise)
            self.seen = round(seen, 7)
            self.passed.append((self.voltage, self.seen))

    def samples(self):
        """Return (voltage, position) of the samples passed since the call before."""
        self.advance()
        rows, self.passed = self.passed, []
        return rows

    def moving(self, voltage):
        return voltage


class Machine:
    """The one that is checked now; a test sets up another."""

    rail = Rail()


class GoodDrive:
    """Keeps every point."""

    faults = ("torn", "doubled", "lost", "garbled", "noise", "silent", "pulled")
    fault_time = 0.3
    call_time = 0.0002

    def __init__(self, port=PORT):
        self.port, self.rail = port, Machine.rail
        self.is_open = self.was_open = self.was_written = False
        self.reads = 0
        self.newest = (0.0, 0.0)

    def open(self):
        if self.port != PORT or self.rail.has("pulled"):
            raise OSError(f"{self.port}: no such port")
        self.claim()
        self.is_open = self.was_open = True
        self.rail.samples()
        self.set(0.0)
        self.newest = (0.0, self.rail.seen)

    def claim(self):
        if self.rail.owner not in (None, self):
            raise OSError(f"{self.port}: busy")
        self.rail.owner = self

    def read(self):
        if self.rail.has("pulled"):
            raise OSError("gone")
        self.reads += 1
        self.rail.clock.take(self.call_time)
        rows, lost = self.rail.samples(), 0
        if self.rail.has("silent"):
            rows = []
        if self.rail.has("lost"):
            lost = len(rows) // 2
            rows = rows[lost:]
        return self.told(rows, lost)

    def told(self, rows, lost):
        if rows:
            self.newest = rows[-1]
        voltage, position = self.newest
        return position, voltage, [*rows] or self.no_rows(), lost

    def no_rows(self):
        import numpy as np

        return np.empty((0, 2))

    def write(self, voltage):
        if not math.isfinite(voltage):
            raise ValueError(f"voltage = {voltage} V: must be a number")
        self.was_written = True
        self.set(voltage)

    def set(self, voltage):
        self.rail.advance()
        self.rail.voltage, self.rail.written_at = voltage, self.rail.clock.time

    def stop(self):
        if self.is_open:
            self.set(0.0)

    def close(self):
        self.stop()
        self.is_open = False
        if self.rail.owner is self:
            self.rail.owner = None

    def fault(self, name):
        self.rail.fault, self.rail.fault_end = name, self.rail.clock.time + self.fault_time


class Found:
    """Breaks `found`: has no stop."""

    def open(self): ...

    def read(self): ...

    def write(self, voltage): ...

    def close(self): ...


class EndsUnopened(GoodDrive):
    """Breaks `ends_unopened`."""

    def stop(self):
        if not self.was_open:
            raise RuntimeError("not open")
        super().stop()


class RefusesUnknownPort(GoodDrive):
    """Breaks `refuses_unknown_port`."""

    def open(self):
        self.port = PORT
        super().open()


class Opens(GoodDrive):
    """Breaks `opens`."""

    def open(self):
        raise OSError(f"{self.port}: the supply is off")


class Reads(GoodDrive):
    """Breaks `reads`."""

    def read(self):
        return 0.0


class RefusesSecond(GoodDrive):
    """Breaks `refuses_second`."""

    def claim(self):
        return


class OpensAtRest(GoodDrive):
    """Breaks `opens_at_rest`."""

    def told(self, rows, lost):
        position, voltage, *rest = super().told(rows, lost)
        return position, voltage if self.was_written else 0.5, *rest


class ClosesTwice(GoodDrive):
    """Breaks `closes_twice`."""

    def close(self):
        if self.was_open and not self.is_open:
            raise RuntimeError("closed already")
        super().close()


class OpensAgain(GoodDrive):
    """Breaks `opens_again`."""

    closed_at = -math.inf

    def open(self):
        if self.rail.clock.time - self.closed_at < 0.1:
            self.rail.position += 0.001
            self.rail.seen += 0.001
        super().open()

    def close(self):
        super().close()
        self.closed_at = self.rail.clock.time


class Told(GoodDrive):
    """Changes what a reading tells."""

    def told(self, rows, lost):
        position, voltage, rows, lost = super().told(rows, lost)
        return self.changed_position(position), self.changed_voltage(voltage), rows, lost

    def changed_position(self, position):
        return position

    def changed_voltage(self, voltage):
        return voltage


class IsFinite(Told):
    """Breaks `is_finite`."""

    def changed_position(self, position):
        return position if self.reads % 100 else math.nan


class IsInMeters(GoodDrive):
    """Breaks `is_in_meters`."""

    def __init__(self, port=PORT):
        super().__init__(port)
        self.rail.position = self.rail.seen = 1.0


class ReadsQuickly(GoodDrive):
    """Breaks `reads_quickly`."""

    call_time = 0.0015


class IsNeverLate(GoodDrive):
    """Breaks `is_never_late`."""

    def read(self):
        found = super().read()
        self.rail.clock.take(0.03 if self.reads == 500 else 0.0)
        return found


class KeepsRate(GoodDrive):
    """Breaks `keeps_rate`."""

    def read(self):
        self.rail.clock.oversleep = 0.006 if self.reads % 5 == 0 else 0.0
        return super().read()


class HasLowNoise(GoodDrive):
    """Breaks `has_low_noise`."""

    def __init__(self, port=PORT):
        super().__init__(port)
        self.rail.noise = 15e-6


class Rests(GoodDrive):
    """Breaks `rests`."""

    def __init__(self, port=PORT):
        super().__init__(port)
        self.rail.drift = 20e-6


class HasNoSpikes(GoodDrive):
    """Breaks `has_no_spikes`."""

    def told(self, rows, lost):
        if rows and not self.was_written and self.reads % 199 == 0:
            rows[-1] = (rows[-1][0], rows[-1][1] + 0.0003)
        return super().told(rows, lost)


class TellsNewest(GoodDrive):
    """Breaks `tells_newest`."""

    def told(self, rows, lost):
        position, *rest = super().told(rows, lost)
        return (rows[0][1] if rows else position), *rest


class SamplesAtRate(GoodDrive):
    """Breaks `samples_at_rate`."""

    def __init__(self, port=PORT):
        super().__init__(port)
        self.rail.rate = 1.02 * RATE


class SamplesWithoutSteps(GoodDrive):
    """Breaks `samples_without_steps`."""

    def read(self):
        if self.reads == 500:
            self.rail.sample += 200
        return super().read()


class LosesNothing(GoodDrive):
    """Breaks `loses_nothing`."""

    def told(self, rows, lost):
        if self.reads == 500:
            rows, lost = rows[1:], 1
        return super().told(rows, lost)


class DoesNothingAtZero(GoodDrive):
    """Breaks `does_nothing_at_zero`."""

    def write(self, voltage):
        super().write(voltage)
        self.rail.creep = 0.001

    def stop(self):
        super().stop()
        self.rail.creep = 0.0


class WritesQuickly(GoodDrive):
    """Breaks `writes_quickly`."""

    def write(self, voltage):
        super().write(voltage)
        self.rail.clock.take(0.0015)


class RefusesNan(GoodDrive):
    """Breaks `refuses_nan`."""

    def write(self, voltage):
        super().write(voltage if math.isfinite(voltage) else 0.0)


class Moves(GoodDrive):
    """Breaks `moves`."""

    def write(self, voltage):
        super().write(0.0 * voltage)


class MovesBothWays(GoodDrive):
    """Breaks `moves_both_ways`."""

    def __init__(self, port=PORT):
        super().__init__(port)
        self.rail.moving = lambda voltage: max(voltage, 0.0)


class HasSign(GoodDrive):
    """Breaks `has_sign`."""

    def __init__(self, port=PORT):
        super().__init__(port)
        self.rail.moving = lambda voltage: -voltage


class TellsVoltage(Told):
    """Breaks `tells_voltage`."""

    def changed_voltage(self, voltage):
        return 0.0


class TellsScale(Told):
    """Breaks `tells_scale`."""

    def changed_voltage(self, voltage):
        return 1.5 * voltage


class TellsInTime(Told):
    """Breaks `tells_in_time`."""

    began = None

    def changed_voltage(self, voltage):
        now = self.rail.clock.time
        self.began = None if not voltage else now if self.began is None else self.began
        return voltage if voltage and now - self.began > 0.08 else 0.0


class Follows(Told):
    """Breaks `follows`."""

    kept = 0.0

    def changed_position(self, position):
        if not self.rail.voltage or self.rail.clock.time % 0.15 > 0.1:
            self.kept = position
        return self.kept


class Resolves(Told):
    """Breaks `resolves`."""

    def __init__(self, port=PORT):
        super().__init__(port)
        self.rail.noise, self.rail.position = 0.0, 20e-6

    def told(self, rows, lost):
        rows = [(voltage, math.floor(position / 40e-6) * 40e-6) for voltage, position in rows]
        return super().told(rows, lost)


class Delayed(GoodDrive):
    """Sets a voltage some time after a stop, unless something else happens before."""

    planned = None

    def read(self):
        if self.planned and self.rail.clock.time >= self.planned[0]:
            voltage, self.planned = self.planned[1], None
            self.set(voltage)
        if self.rail.voltage:
            self.rail.written_at = max(self.rail.written_at, self.fed())
        return super().read()

    def fed(self):
        return -math.inf

    def write(self, voltage):
        self.planned = None
        super().write(voltage)

    def close(self):
        self.planned = None
        super().stop()
        super().close()


class Stops(Delayed):
    """Breaks `stops`."""

    def stop(self):
        if self.planned is None:
            self.planned = self.rail.clock.time + 0.2, 0.0

    def fed(self):
        return self.rail.clock.time if self.planned else -math.inf


class StopsQuickly(GoodDrive):
    """Breaks `stops_quickly`."""

    def stop(self):
        super().stop()
        self.rail.clock.take(0.05 if self.is_open else 0.0)


class StaysStopped(Delayed):
    """Breaks `stays_stopped`."""

    def stop(self):
        voltage = self.rail.voltage
        super().stop()
        if voltage:
            self.planned = self.rail.clock.time + 0.2, voltage


class StopsTwice(GoodDrive):
    """Breaks `stops_twice`."""

    stopped = False

    def stop(self):
        if self.stopped:
            raise RuntimeError("stopped already")
        super().stop()
        self.stopped = self.is_open

    def open(self):
        self.stopped = False
        super().open()

    def write(self, voltage):
        self.stopped = False
        super().write(voltage)

    def close(self):
        self.stopped = False
        super().close()


class StopsFromSecondThread(GoodDrive):
    """Breaks `stops_from_second_thread`."""

    def stop(self):
        if threading.current_thread().name == "second-stop":
            raise RuntimeError("of another thread")
        super().stop()


class MovesAgain(GoodDrive):
    """Breaks `moves_again`."""

    stopped_at = -math.inf

    def stop(self):
        super().stop()
        self.stopped_at = self.rail.clock.time

    def write(self, voltage):
        is_off = self.rail.clock.time - self.stopped_at < 0.3
        super().write(voltage * (not is_off))


class WatchdogStops(GoodDrive):
    """Breaks `watchdog_stops`."""

    def __init__(self, port=PORT):
        super().__init__(port)
        self.rail.watchdog = math.inf


class CloseStops(GoodDrive):
    """Breaks `close_stops`."""

    def open(self):
        super().open()
        self.rail.watchdog = WATCHDOG

    def close(self):
        self.rail.advance()
        self.rail.watchdog = math.inf
        self.is_open = False
        super().close()


class Misreads(GoodDrive):
    """Takes what a fault makes of a frame for a position."""

    misread = ""

    def told(self, rows, lost):
        if rows and self.rail.has(self.misread):
            rows[-1] = (rows[-1][0], rows[-1][1] + 0.001)
        return super().told(rows, lost)


class SurvivesTorn(Misreads):
    """Breaks `survives_torn`."""

    misread = "torn"


class SurvivesGarbled(Misreads):
    """Breaks `survives_garbled`."""

    misread = "garbled"


class SurvivesNoise(Misreads):
    """Breaks `survives_noise`."""

    misread = "noise"


class SurvivesDoubled(GoodDrive):
    """Breaks `survives_doubled`."""

    def told(self, rows, lost):
        return super().told(rows * 2 if self.rail.has("doubled") else rows, lost)


class SurvivesLost(GoodDrive):
    """Breaks `survives_lost`."""

    def told(self, rows, lost):
        return super().told(rows, 0)


class SurvivesSilent(GoodDrive):
    """Breaks `survives_silent`."""

    def read(self):
        if self.rail.has("silent"):
            self.rail.clock.take(0.1)
        return super().read()


class SurvivesPulled(GoodDrive):
    """Breaks `survives_pulled`."""

    def fault(self, name):
        if name != "pulled":
            super().fault(name)


def broken_at(check):
    """Return the name of the class that breaks the point of a check."""
    return "".join(word.capitalize() for word in check.split("_"))
