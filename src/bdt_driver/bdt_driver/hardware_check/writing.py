"""Checks of moving a machine, within the limits that the user gave."""

import math

import numpy as np

from bdt_driver.guarded_drive import DriveError
from bdt_driver.hardware_check.check import Check, require
from bdt_driver.hardware_check.drive_stand import (
    LONGEST_STROKE,
    SETTLING_TIME,
    STROKE_SHARE,
    DriveStand,
)
from bdt_driver.hardware_check.reading import FINEST_SHARE, LARGEST_CALL_SHARE
from bdt_driver.hardware_check.record import Record

LATEST_ANSWER = 0.05
"""Time [s] in which a voltage must be told after it was written."""
SCALE_TOLERANCE = 0.02
"""Relative difference of voltages written and told."""
LONGEST_STUCK = 0.05
"""Time [s] for which a position may stay the same while the platform moves."""
WRITES = 50


def _does_nothing_at_zero(stand: DriveStand) -> str:
    record = stand.read_for(SETTLING_TIME, 0.0)
    told, moved = abs(record.largest_told()), abs(record.change)
    allowed = max(FINEST_SHARE * stand.travel, 8.0 * stand.noise)
    require(told == 0.0, f"tells {told:g} V after 0 V was written")
    require(moved <= allowed, f"moves by {moved * 1e6:.3g} um, must be {allowed * 1e6:.3g} um")
    return f"moves by {moved * 1e6:.3g} um"


def _writes_quickly(stand: DriveStand) -> str:
    times = [stand.duration_of(stand.drive.write, 0.0) for _ in range(WRITES)]
    typical, allowed = float(np.median(times)), LARGEST_CALL_SHARE * stand.period
    text = f"{typical * 1e3:.3g} ms"
    require(typical <= allowed, f"{text}, must be at most {allowed * 1e3:.3g} ms")
    return text


def _refuses_nan(stand: DriveStand) -> str:
    try:
        stand.drive.write(math.nan)
    except DriveError as error:
        return str(error)
    finally:
        stand.settle()
    require(condition=False, text="takes it without a word")
    return ""


def _moves(stand: DriveStand) -> str:
    moved = max(abs(record.change) for record in stand.motion)
    allowed = _least_motion(stand)
    text = f"{moved * 1e6:.3g} um with {stand.voltage:g} V"
    require(moved >= allowed, f"{text}, must be {allowed * 1e6:.3g} um in {LONGEST_STROKE:g} s")
    return text


def _moves_both_ways(stand: DriveStand) -> str:
    forward, backward = (record.change for record in stand.motion)
    least = _least_motion(stand)
    text = f"{forward * 1e6:+.3g} um and {backward * 1e6:+.3g} um"
    is_there = min(abs(forward), abs(backward)) >= least
    require(is_there and forward * backward < 0.0, text)
    return text


def _has_sign(stand: DriveStand) -> str:
    forward, backward = (record.change for record in stand.motion)
    require(forward > backward, f"{stand.voltage:g} V move the platform by {forward * 1e6:+.3g} um")
    return "a positive voltage moves the platform to larger positions"


def _tells_voltage(stand: DriveStand) -> str:
    for voltage, record in _strokes(stand):
        told = record.largest_told()
        require(told * voltage > 0.0, f"tells {told:g} V while {voltage:g} V are written")
    return "with its sign"


def _tells_scale(stand: DriveStand) -> str:
    for voltage, record in _strokes(stand):
        told = record.largest_told()
        require(
            abs(told / voltage - 1.0) <= SCALE_TOLERANCE,
            f"tells {told:g} V for {voltage:g} V",
        )
    return f"{stand.voltage:g} V are told as such"


def _tells_in_time(stand: DriveStand) -> str:
    delay = max(record.time_until_told(voltage) for voltage, record in _strokes(stand))
    text = f"after {delay * 1e3:.3g} ms"
    require(delay <= LATEST_ANSWER, f"{text}, must be at most {LATEST_ANSWER * 1e3:g} ms")
    return text


def _follows(stand: DriveStand) -> str:
    longest = max(_longest_stuck(record, stand.period) for _, record in _strokes(stand))
    text = f"the same for {longest * 1e3:.3g} ms at most"
    require(longest <= LONGEST_STUCK, f"{text}, must be {LONGEST_STUCK * 1e3:g} ms")
    return text


def _resolves(stand: DriveStand) -> str:
    positions = np.unique(np.concatenate([record.positions for record in stand.motion]))
    step = float(np.min(np.diff(positions)))
    allowed = FINEST_SHARE * stand.travel
    text = f"{step * 1e6:.3g} um"
    require(step <= allowed, f"{text}, must be at most {allowed * 1e6:.3g} um")
    return text


def _least_motion(stand: DriveStand) -> float:
    return max(0.2 * STROKE_SHARE * stand.travel, 10.0 * stand.noise)


def _strokes(stand: DriveStand) -> list[tuple[float, Record]]:
    return [(stand.voltage, stand.motion.forward), (-stand.voltage, stand.motion.backward)]


def _longest_stuck(record: Record, period: float) -> float:
    """Return the longest time [s] without a new position, once the platform moves."""
    positions = record.positions
    way = np.abs(positions - positions[0])
    begin = int(np.argmax(way > 0.2 * np.max(way)))
    is_new = np.flatnonzero(np.diff(positions[begin:], prepend=np.nan) != 0.0)
    # Readings are counted, not time: a computer that is busy reads nothing, and no sensor is stuck.
    longest = int(np.max(np.diff(is_new, append=len(positions) - begin)))
    return longest * period


WRITING = (
    Check(
        "does_nothing_at_zero",
        _does_nothing_at_zero,
        "A controller inside its dead zone commands 0 V: the machine must rest.",
        "Trim the amplifier's offset (or set the controller's voltage_offset), and tell 0 V.",
        moves=True,
    ),
    Check(
        "writes_quickly",
        _writes_quickly,
        "What writing takes delays the command.",
        "Send without waiting for an answer; the next reading tells what was applied.",
        moves=True,
    ),
    Check(
        "refuses_nan",
        _refuses_nan,
        "What is no number must not reach an amplifier, whoever lets it through.",
        "Raise in write for what is not finite.",
        moves=True,
    ),
    Check(
        "moves",
        _moves,
        "Without motion there is nothing to control.",
        "Look at supply, enable input and emergency stop; or friction needs more voltage "
        "(limits.voltage).",
        needs=("reads", "is_finite", "is_in_meters"),
        moves=True,
    ),
    Check(
        "moves_both_ways",
        _moves_both_ways,
        "A machine that goes one way only cannot be controlled.",
        "Look whether the amplifier takes both signs, and for an end switch.",
        needs=("moves",),
        moves=True,
    ),
    Check(
        "has_sign",
        _has_sign,
        "With the wrong sign the controller runs away to the end of the travel.",
        "Swap the motor's wires, or change the sign in write and in the voltage of read.",
        needs=("moves",),
        moves=True,
    ),
    Check(
        "tells_voltage",
        _tells_voltage,
        "The twin learns from the voltage as applied; without it there is no estimate.",
        "Return the voltage that the amplifier applies, or the one that was written.",
        needs=("moves",),
        moves=True,
    ),
    Check(
        "tells_scale",
        _tells_scale,
        "A wrong scale is a wrong motor constant to the twin.",
        "Return volts. If the amplifier limits the voltage, check with less (limits.voltage).",
        needs=("tells_voltage",),
        moves=True,
    ),
    Check(
        "tells_in_time",
        _tells_in_time,
        "A delay between writing and acting takes phase from the controller.",
        "Look for buffers on the way; on USB at the latency timer.",
        needs=("tells_voltage",),
        moves=True,
    ),
    Check(
        "follows",
        _follows,
        "A sensor that repeats its last value hides motion, and then makes it a jump.",
        "Raise when the sensor has no new value; look at its update rate and its cable.",
        needs=("moves",),
        moves=True,
    ),
    Check(
        "resolves",
        _resolves,
        "Steps of the position are noise to the twin, and blows for the derivative.",
        "Use the sensor's full resolution; do not round in read.",
        needs=("moves",),
        moves=True,
    ),
)
"""The checks, in their order."""
