"""``ros2`` commands: as processes of their own, and within this one, which spares their start."""

import io
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout

from ros2cli.cli import main

COMMAND = [sys.executable, "-c", "from ros2cli.cli import main; raise SystemExit(main())"]
TIMEOUT_S = 120


def ros2_processes(*commands):
    """Run commands at the same time; the output, errors and exit code of each."""
    processes = [
        subprocess.Popen(
            [*COMMAND, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        for words in commands
    ]
    try:
        return [
            (*process.communicate(timeout=TIMEOUT_S), process.returncode) for process in processes
        ]
    finally:
        for process in processes:
            process.kill()


def ros2_all(*commands):
    """Run commands one after the other in this process; output, errors and exit code of each."""
    return [ros2(*words) for words in commands]


def ros2(*words):
    """Run a command in this process; its output, errors and exit code."""
    with redirect_stdout(io.StringIO()) as out, redirect_stderr(io.StringIO()) as errors:
        code = main(words)
    return out.getvalue(), errors.getvalue(), int(code)


def failure(text, code=1):
    """Make the result of a command that fails with one line."""
    return ("", f"{text}\n", code)
