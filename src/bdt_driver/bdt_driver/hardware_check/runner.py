"""Runs the checks one after the other, each only where it can say something."""

import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, wait

from bdt_driver.guarded_drive import DriveError
from bdt_driver.hardware_check.check import (
    Check,
    CheckFailedError,
    CheckResult,
    CheckSkippedError,
    Outcome,
)
from bdt_driver.hardware_check.connecting import CONNECTING
from bdt_driver.hardware_check.drive_stand import DriveStand
from bdt_driver.hardware_check.line_faults import LINE_FAULTS
from bdt_driver.hardware_check.reading import READING
from bdt_driver.hardware_check.stopping import STOPPING
from bdt_driver.hardware_check.writing import WRITING

CHECKS = (*CONNECTING, *READING, *WRITING, *STOPPING, *LINE_FAULTS)
"""All checks, in the order in which they run."""

HANGING = 30.0
"""Time [s] after which a check has met a call that will not return."""


def run_checks(
    stand: DriveStand, *, may_move: bool, checks: Sequence[Check] = CHECKS, hanging: float = HANGING
) -> Iterator[CheckResult]:
    """Run the checks and yield the result of each.

    Parameters
    ----------
    stand : DriveStand
        The drive and its limits.
    may_move : bool
        Whether checks that move the machine run.
    checks : sequence of Check
        Which checks, in an order in which each comes behind what it needs.
    hanging : float
        Time [s] after which a check has met a call that does not return; then no more run.
    """
    well: set[str] = set()
    hangs_in = ""
    for check in checks:
        missing = [name for name in check.needs if name not in well]
        if hangs_in:
            result = CheckResult(check, Outcome.SKIPPED, f"{hangs_in} has not come to an end")
        elif check.moves and not may_move:
            result = CheckResult(check, Outcome.SKIPPED, "may move the machine: needs --yes")
        elif missing:
            result = CheckResult(check, Outcome.SKIPPED, f"needs {' and '.join(missing)}")
        else:
            ended = _result_within(check, stand, hanging)
            if ended is None:
                hangs_in = check.name
                text = f"a call of the drive has not returned for {hanging:g} s"
                ended = CheckResult(check, Outcome.FAILED, text)
            result = ended
        if result.outcome is Outcome.OK:
            well.add(check.name)
        elif result.outcome is Outcome.FAILED and not hangs_in and "opens" in well:
            fault = _recovered(stand)
            if fault:
                well.clear()
                result = result._replace(text=f"{result.text}; and does not open again: {fault}")
        yield result


def _result_within(check: Check, stand: DriveStand, hanging: float) -> CheckResult | None:
    """Return the result of a check; None if a call of the drive hangs."""
    ended: Future[CheckResult] = Future()

    def run() -> None:
        try:
            ended.set_result(_result(check, stand))
        except BaseException as error:  # noqa: BLE001 - raised again in the caller's thread
            ended.set_exception(error)

    threading.Thread(target=run, name=check.name, daemon=True).start()
    wait([ended], hanging)
    return ended.result() if ended.done() else None


def _result(check: Check, stand: DriveStand) -> CheckResult:
    try:
        return CheckResult(check, Outcome.OK, check.run(stand))
    except CheckSkippedError as skipped:
        return CheckResult(check, Outcome.SKIPPED, str(skipped))
    except (CheckFailedError, DriveError) as failed:
        return CheckResult(check, Outcome.FAILED, str(failed))


def _recovered(stand: DriveStand) -> str:
    """Bring the drive back after a failed check; return why it cannot be brought back."""
    try:
        stand.reopen()
    except DriveError as error:
        return str(error)
    return ""
