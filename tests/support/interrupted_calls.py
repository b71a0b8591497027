"""Calls that Ctrl-C breaks off at any moment, again and again, in a process of their own."""

import os
import random
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

PROGRAM = """
from interrupted_calls import interrupt
{preparation}
interrupt(lambda: {call})
"""


def end_of_interrupted(preparation: str, call: str) -> tuple[int, str]:
    """Return exit code and standard error of a process that is interrupted in the midst of calls.

    Parameters
    ----------
    preparation : str
        Statements before the first call.
    call : str
        Expression that is interrupted.
    """
    # Where a colcon workspace is sourced the packages are on this path, too.
    path = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(preparation=preparation, call=call)],
        env={**os.environ, "PYTHONPATH": path},
        check=False,
        capture_output=True,
        text=True,
        timeout=120,
    )
    return done.returncode, done.stderr


def interrupt(call: Callable[[], object], interruptions: int = 300) -> None:
    """Have an alarm raise KeyboardInterrupt in calls; whatever else they raise is not caught."""
    signal.signal(signal.SIGALRM, signal.default_int_handler)
    moments = random.Random(26)  # noqa: S311 - moments, no secrets
    call()
    for _ in range(interruptions):
        try:
            # Within: on a busy machine the alarm may come before the next line is begun.
            signal.setitimer(signal.ITIMER_REAL, moments.uniform(5e-5, 5e-4))
            while True:
                call()
        except KeyboardInterrupt:
            pass
