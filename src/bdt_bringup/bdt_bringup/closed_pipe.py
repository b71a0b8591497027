"""Standard output that takes no more: a reader that is gone, a disk that is full.

``bdt ... | head`` ends as any other tool does, without a word.
"""

import errno
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from bdt_msgs_py.command_errors import BAD_INPUT, complain

CLOSED_PIPE = 128 + signal.SIGPIPE
"""Exit code of a program that writes where nobody reads, as shells have it."""

FULL_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EIO)
"""Errors of a disk to which standard output goes."""


@contextmanager
def quiet_when_nobody_reads() -> Iterator[None]:
    """Turn a closed pipe of standard output or standard error into :data:`CLOSED_PIPE`.

    The signal itself stays ignored, as Python has it: it would end the program at once, and with
    it nodes that run and a bag that is being written.

    Raises
    ------
    SystemExit
        When nobody reads any more.
    """
    try:
        try:
            yield
        finally:
            # What waits in the buffer would meet the closed pipe after this program's last line.
            if sys.stdout is not None:
                sys.stdout.flush()
    except BrokenPipeError:
        _write_to_nowhere()
        raise SystemExit(CLOSED_PIPE) from None
    except OSError as error:
        if error.errno not in FULL_DISK:
            raise
        code = complain(f"standard output: {error.strerror}", BAD_INPUT)
        _write_to_nowhere()
        raise SystemExit(code) from None
    except SystemExit as end:
        # rich meets the closed pipe first, and asks for an end with an exit code of its own.
        if isinstance(end.__context__, BrokenPipeError):
            raise SystemExit(CLOSED_PIPE) from None
        raise


def _write_to_nowhere() -> None:
    """Give what is still in the buffers a way out: Python tries once more when it ends."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            os.dup2(nowhere, stream.fileno())
    os.close(nowhere)
