"""Checks with faults that a drive offers to have, for a class whose device is emulated.

Such a drive has a method ``fault(name)``, the names in ``faults``, and in ``fault_time`` how long a
fault lasts [s].
"""

import math
from contextlib import suppress
from functools import partial

import numpy as np

from bdt_driver.guarded_drive import DriveError
from bdt_driver.hardware_check.check import Check, CheckSkippedError, require
from bdt_driver.hardware_check.drive_stand import DriveStand
from bdt_driver.hardware_check.reading import SPIKE_SHARE, found_rate
from bdt_driver.hardware_check.record import Record

LARGEST_ERROR = 0.015
"""Time [s] that the samples of a fault may be too many or too few, those told as lost included."""
TIME_BEFORE = 0.3
"""Time [s] for which a drive is read before a fault."""
TIME_AFTER = 0.5
"""Time [s] for which a drive is read after a fault."""
LONGEST_RETURN = 10.0
"""Time [s] in which a drive must open again after its cable was pulled."""
LONGEST_END = 1.0
"""Time [s] that stop and close may take without a cable."""


def _survives(name: str, stand: DriveStand) -> str:
    record, error = _record_of(name, stand)
    if error:
        stand.reopen()
        return f"raises, and opens again: {error}"
    _require_positions(stand, record)
    if not stand.brings_samples:
        return "the positions are right"
    # Medians before and after: a computer that is busy reads late now and then.
    ended = np.array(record.ended)
    ahead = record.passed_samples / found_rate(stand) - ended
    before = ended < ended[0] + TIME_BEFORE
    after = ended > ended[-1] - TIME_BEFORE
    surplus = float(np.median(ahead[after]) - np.median(ahead[before]))
    text = f"{record.lost_samples} samples told as lost, {surplus * 1e3:+.2f} ms too many"
    require(abs(surplus) <= LARGEST_ERROR, f"{text}, must be within {LARGEST_ERROR * 1e3:g} ms")
    return text


def _survives_silence(stand: DriveStand) -> str:
    record, error = _record_of("silent", stand)
    if error:
        stand.reopen()
        return f"raises, and opens again: {error}"
    worst, allowed = float(np.max(record.call_times)), stand.settings.command_timeout
    text = f"the slowest reading lasts {worst * 1e3:.3g} ms"
    require(worst <= allowed, f"{text}, must be at most {allowed * 1e3:.3g} ms")
    _require_positions(stand, record)
    return text


def _survives_pulled_cable(stand: DriveStand) -> str:
    _, error = _record_of("pulled", stand)
    require(bool(error), "reads on as if nothing had happened")
    for call in (stand.drive.stop, stand.drive.close):
        began = stand.clock.now()
        with suppress(DriveError):  # there is no cable: it may say so, and must not wait
            call()
        lasted = stand.clock.now() - began
        require(lasted <= LONGEST_END, f"{call.__name__} lasts {lasted:.3g} s without a cable")
    end = stand.clock.now() + LONGEST_RETURN
    while True:
        try:
            stand.drive.open()
            break
        except DriveError as missing:
            now = stand.clock.now()
            require(now < end, f"does not open again: {missing}")
            stand.clock.sleep_until(now + 0.1)
    require(math.isfinite(stand.drive.read().position), "opens again, and has no position")
    return f"{error}; and opens again"


def _record_of(name: str, stand: DriveStand) -> tuple[Record, str]:
    """Have a fault and return the readings before, meanwhile and after, or what was raised."""
    drive = stand.drive.drive
    if name not in getattr(drive, "faults", ()):
        raise CheckSkippedError(f"the drive offers no fault {name!r} (see `fault`)")
    stand.wait_for_rest()
    before = stand.read_for(TIME_BEFORE)
    drive.fault(name)
    try:
        return before + stand.read_for(drive.fault_time + TIME_AFTER), ""
    except DriveError as error:
        return Record(), str(error)


def _require_positions(stand: DriveStand, record: Record) -> None:
    positions = record.positions
    require(bool(np.isfinite(positions).all()), "a reading is no number")
    jump = float(np.max(np.abs(positions - np.median(positions))))
    allowed = max(SPIKE_SHARE * stand.travel, 10.0 * stand.noise)
    require(jump <= allowed, f"a position is off by {jump * 1e6:.3g} um")


def _line_check(fault: str, reason: str) -> Check:
    return Check(
        f"survives_{fault}",
        partial(_survives, fault),
        reason,
        "Check every frame (length, checksum, number) and drop it if anything is wrong.",
        needs=("reads", "is_finite"),
    )


LINE_FAULTS = (
    _line_check("torn", "A cable that is touched tears frames; half a number is no number."),
    _line_check("doubled", "A repeated frame must not make time go faster."),
    _line_check("lost", "A lost frame must be told, or all that follows is at the wrong time."),
    _line_check("garbled", "A flipped bit must not become a position."),
    _line_check("noise", "Bytes between the frames must not be taken for one."),
    Check(
        "survives_silent",
        _survives_silence,
        "A device that hangs must not make the driver hang.",
        "Let read return what there is, or raise; never wait longer than command_timeout.",
        needs=("reads", "is_finite"),
    ),
    Check(
        "survives_pulled",
        _survives_pulled_cable,
        "A pulled cable is a fault that must be told, and end when the cable is back.",
        "Let the port's error through in read and write; open it anew in open.",
        needs=("reads", "is_finite"),
    ),
)
"""The checks, in their order."""
