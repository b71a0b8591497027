"""Checks of taking the voltage off a machine that moves."""

import math
import threading

import numpy as np

from bdt_driver.guarded_drive import DriveError
from bdt_driver.hardware_check.check import Check, require
from bdt_driver.hardware_check.drive_stand import SETTLING_TIME, DriveStand
from bdt_driver.hardware_check.record import Record
from bdt_driver.hardware_check.writing import LATEST_ANSWER

LONGEST_STOP = 0.02
"""Time [s] that a call of stop may last."""
LONGEST_WATCHDOG = 0.5
"""Time [s] after which a device that hears nothing must have taken the voltage off."""
CLOSED_TIME = 0.3
"""Time [s] for which a drive stays closed."""
JOIN_TIMEOUT = 5.0


def _stops(stand: DriveStand) -> str:
    voltage, record = _stopped(stand)
    delay = record.time_until_zero(voltage)
    text = f"after {delay * 1e3:.3g} ms"
    require(delay <= LATEST_ANSWER, f"{text}, must be at most {LATEST_ANSWER * 1e3:g} ms")
    return text


def _stops_quickly(stand: DriveStand) -> str:
    stand.stroke(stand.inward())
    duration = stand.duration_of(stand.drive.stop)
    stand.settle()
    text = f"{duration * 1e3:.3g} ms"
    require(duration <= LONGEST_STOP, f"{text}, must be at most {LONGEST_STOP * 1e3:g} ms")
    return text


def _stays_stopped(stand: DriveStand) -> str:
    voltage, record = _stopped(stand)
    is_on = np.abs(record.voltages) > 0.01 * abs(voltage)
    first = int(np.argmin(is_on))
    again = np.flatnonzero(is_on[first:])
    after = record.ended[first + int(again[0])] - record.began[0] if len(again) else math.inf
    require(not len(again), f"after {after:.3g} s the voltage is on again")
    return f"for {SETTLING_TIME:g} s"


def _stops_twice(stand: DriveStand) -> str:
    stand.drive.stop()
    stand.drive.stop()
    return "the second time nothing happens"


def _stops_from_second_thread(stand: DriveStand) -> str:
    stand.stroke(stand.inward())
    faults: list[str] = []

    def stop() -> None:
        try:
            # Not through the guard: the node's second thread calls the class itself, too.
            stand.drive.drive.stop()
        except Exception as error:  # noqa: BLE001 - somebody's code, told below
            faults.append(f"{type(error).__name__}: {error}")

    thread = threading.Thread(target=stop, name="second-stop", daemon=True)
    thread.start()
    stand.read_for(10 * stand.period)
    thread.join(JOIN_TIMEOUT)
    is_hanging = thread.is_alive()
    stand.settle()
    require(not is_hanging, "stop does not return while another thread reads")
    require(not faults, "".join(faults))
    return "while the first one reads"


def _moves_again(stand: DriveStand) -> str:
    voltage = stand.inward()
    stand.stroke(voltage)
    stand.drive.stop()
    # Until the stop is told, what is told is the voltage before it.
    stand.read_for(LATEST_ANSWER)
    record = stand.read_for(2.0 * LATEST_ANSWER, voltage)
    stand.settle()
    delay = record.time_until_told(voltage)
    require(math.isfinite(delay), "the first voltage after a stop is not applied")
    return f"after {delay * 1e3:.3g} ms"


def _watchdog_stops(stand: DriveStand) -> str:
    voltage = stand.inward()
    stand.stroke(voltage, 2.0 * LATEST_ANSWER)
    record = stand.read_for(LONGEST_WATCHDOG)
    stand.settle()
    delay = record.time_until_zero(voltage)
    if math.isinf(delay):
        lasted = record.ended[-1] - record.began[0]
        require(condition=False, text=f"{voltage:g} V are still on after {lasted:.2g} s")
    return f"after {delay * 1e3:.3g} ms"


def _close_stops(stand: DriveStand) -> str:
    voltage = stand.inward()
    stroke = stand.stroke(voltage)
    speed = abs(stroke.change) / (stroke.ended[-1] - stroke.began[0])
    position = stroke.readings[-1].position
    stand.drive.close()
    closed = stand.clock.now()
    stand.clock.sleep_until(closed + CLOSED_TIME)
    stand.drive.open()
    record = stand.read_for(10 * stand.period)
    stand.settle()
    moved = abs(record.readings[-1].position - position)
    allowed = max(0.5 * speed * CLOSED_TIME, 10.0 * stand.noise)
    text = f"moves by {moved * 1e6:.3g} um in {CLOSED_TIME:g} s"
    require(moved <= allowed, f"{text} after it was closed, must be {allowed * 1e6:.3g} um")
    return text


def _stopped(stand: DriveStand) -> tuple[float, Record]:
    """Push, stop, and return the voltage and the readings after it was stopped."""
    voltage = stand.inward()
    stand.stroke(voltage)
    stand.drive.stop()
    try:
        record = stand.read_for(SETTLING_TIME)
    finally:
        _write_zero(stand)
    stand.wait_for_rest()
    return voltage, record


def _write_zero(stand: DriveStand) -> None:
    try:
        stand.drive.write(0.0)
    except DriveError:
        # Reading has failed before, and that is told.
        return


STOPPING = (
    Check(
        "stops",
        _stops,
        "Stop is the last thing between a fault and the end of the travel.",
        "Let stop take the voltage off at once, without a ramp.",
        needs=("moves", "tells_voltage"),
        moves=True,
    ),
    Check(
        "stops_quickly",
        _stops_quickly,
        "A node that ends calls stop, and its watchdog does in a thread of its own.",
        "Send and do not wait.",
        needs=("moves",),
        moves=True,
    ),
    Check(
        "stays_stopped",
        _stays_stopped,
        "After a stop nobody commands; only the next write may move the machine.",
        "Let the device forget the voltage when it stops; let no thread of yours write again.",
        needs=("moves", "tells_voltage"),
        moves=True,
    ),
    Check(
        "stops_twice",
        _stops_twice,
        "The node stops whatever the state, when it is disarmed and when it ends.",
        "Let stop return when the voltage is off already.",
    ),
    Check(
        "stops_from_second_thread",
        _stops_from_second_thread,
        "When another method does not return, the driver calls stop from a second thread.",
        "Hold no lock while you wait for the device; let stop need none.",
        needs=("moves",),
        moves=True,
    ),
    Check(
        "moves_again",
        _moves_again,
        "After disarming and arming, or a silence of commands, the next write must act.",
        "Let write enable the amplifier again if stop disables it.",
        needs=("moves", "tells_voltage"),
        moves=True,
    ),
    Check(
        "watchdog_stops",
        _watchdog_stops,
        "A process that is killed, or a computer that hangs, takes nothing off.",
        "Have the device take the voltage off when no command comes for a tenth of a second.",
        needs=("moves", "tells_voltage"),
        moves=True,
    ),
    Check(
        "close_stops",
        _close_stops,
        "A drive that is closed while it moves must not go on.",
        "Take the voltage off in close, before the connection goes.",
        needs=("moves",),
        moves=True,
    ),
)
"""The checks, in their order."""
