"""Checks of making, opening and closing a drive."""

import inspect
from contextlib import suppress

import numpy as np

from bdt_driver.guarded_drive import DriveError, GuardedDrive
from bdt_driver.hardware_check.check import Check, CheckSkippedError, require
from bdt_driver.hardware_check.drive_stand import DriveStand

NO_PORT = "/dev/no-such-port"
LONGEST_OPENING = 10.0
"""Time [s] in which a drive must open."""


def _is_found(stand: DriveStand) -> str:
    stand.another_drive()
    return stand.settings.driver


def _ends_unopened(stand: DriveStand) -> str:
    drive = stand.another_drive()
    drive.stop()
    drive.close()
    return "stop and close are harmless"


def _refuses_unknown_port(stand: DriveStand) -> str:
    drive = stand.another_drive(port=_with_port(stand, NO_PORT))
    try:
        drive.open()
    except DriveError as error:
        text = str(error)
    else:
        text = ""
    finally:
        _close(drive)
    require(bool(text), f"opens with port {NO_PORT}, which there is not")
    require(NO_PORT in text, f"does not name the port: {text}")
    return text


def _opens(stand: DriveStand) -> str:
    duration = stand.duration_of(stand.drive.open)
    require(duration < LONGEST_OPENING, f"{duration:.3g} s, must be below {LONGEST_OPENING:g} s")
    return f"in {duration * 1e3:.3g} ms"


def _refuses_second(stand: DriveStand) -> str:
    drive = stand.another_drive(port=_with_port(stand, stand.options.get("port")))
    try:
        drive.open()
    except DriveError as error:
        return str(error)
    finally:
        _close(drive)
    require(condition=False, text="a second drive opens the same port")
    return ""


def _opens_at_rest(stand: DriveStand) -> str:
    told = float(np.max(np.abs(stand.at_rest.voltages)))
    require(told == 0.0, f"tells {told:g} V before anything was written")
    return "0 V before anything is written"


def _closes_twice(stand: DriveStand) -> str:
    stand.drive.close()
    stand.drive.close()
    return "the second time nothing happens"


def _opens_again(stand: DriveStand) -> str:
    stand.drive.stop()
    stand.drive.close()
    stand.drive.open()
    positions = stand.read_for(10 * stand.period).positions
    far = abs(float(np.nanmedian(positions) - np.nanmedian(stand.at_rest.positions[-10:])))
    require(
        far < 0.02 * stand.travel,
        f"the platform is {far:g} m from where it was before the drive was closed",
    )
    return "and the position is the same"


def _close(drive: GuardedDrive) -> None:
    """Close a drive whose opening was to fail; what happens then has a check of its own."""
    with suppress(DriveError):
        drive.close()


def _with_port(stand: DriveStand, port: object) -> object:
    drive = type(stand.drive.drive)
    if "port" not in inspect.signature(drive).parameters:
        raise CheckSkippedError("the class has no argument `port`")
    if port is None:
        return inspect.signature(drive).parameters["port"].default
    return port


CONNECTING = (
    Check(
        "found",
        _is_found,
        "The driver node makes a drive from its class and the parameters drive.*.",
        "Give module:name of a class with open, read, write, stop and close.",
        needs=(),
    ),
    Check(
        "ends_unopened",
        _ends_unopened,
        "When opening fails the node stops and closes what it has not opened.",
        "Let stop and close return when there is no connection.",
        needs=("found",),
    ),
    Check(
        "refuses_unknown_port",
        _refuses_unknown_port,
        "A wrong name is the commonest mistake of all; the message must lead to it.",
        "Let open raise an error that holds the name of the port.",
        needs=("found",),
    ),
    Check(
        "opens",
        _opens,
        "Without a connection there is nothing to check.",
        "Look at the cable, the name of the port, the rights to it, and the device's supply.",
        needs=("found",),
    ),
    Check(
        "reads",
        lambda stand: f"{len(stand.at_rest.readings)} readings",
        "A reading is position, voltage and, with a sampling_rate, samples and how many were lost.",
        "Return (position [m], voltage [V]) or (position, voltage, samples of shape (n, 2), lost).",
        needs=("opens",),
    ),
    Check(
        "refuses_second",
        _refuses_second,
        "Two programs on one amplifier drive the machine against each other.",
        "Open the port exclusively.",
    ),
    Check(
        "opens_at_rest",
        _opens_at_rest,
        "An open drive that is not armed must not move.",
        "Let open set the voltage to zero, and tell it as zero until the first write.",
    ),
    Check(
        "closes_twice",
        _closes_twice,
        "A node that ends because of a fault may close what is closed.",
        "Let close return when there is no connection.",
    ),
    Check(
        "opens_again",
        _opens_again,
        "After a fault the node closes the drive and opens it again; the position must be the old "
        "one.",
        "Let open begin anew whatever was before, and keep the sensor's zero in the device.",
    ),
)
"""The checks, in their order."""
