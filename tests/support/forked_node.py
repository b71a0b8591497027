"""A node as a process forked from one that has imported every node: it runs at once."""

import os
import sys
from functools import cache
from importlib import import_module
from multiprocessing import forkserver, get_context
from pathlib import Path

_CONTEXT = get_context("forkserver")
_CONTEXT.set_forkserver_preload(["node_imports"])


@cache
def _start_server():
    """Start the process that nodes are forked from: it finds modules where this one does."""
    before = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = os.pathsep.join(sys.path)
    try:
        forkserver.ensure_running()
    finally:
        del os.environ["PYTHONPATH"]
        if before is not None:
            os.environ["PYTHONPATH"] = before


class ForkedNode:
    """A node that runs, with what of :class:`subprocess.Popen` a loop under faults asks for.

    Parameters
    ----------
    module : str
        Python module with the node's ``main``.
    arguments : sequence of str
        Its arguments, without the program's name.
    log : Path
        File for all that it says.
    environment : dict of str to str
        Variables that are set beside those of this process.

    Attributes
    ----------
    pid : int
        Its number.
    """

    def __init__(self, module, arguments, log, environment):
        _start_server()
        self._process = _CONTEXT.Process(
            target=_run, args=(module, list(arguments), str(log), dict(environment)), name=module
        )
        self._process.start()
        self.pid = self._process.pid

    @property
    def returncode(self):
        """Exit code, a signal's number negated, None while the node runs."""
        return self._process.exitcode

    def poll(self):
        """Return the exit code, None while the node runs."""
        return self._process.exitcode

    def wait(self, timeout=None):
        """Wait for the end and return the exit code; TimeoutError if it does not come."""
        self._process.join(timeout)
        if self.returncode is None:
            raise TimeoutError(f"{self._process.name} has not ended after {timeout:g} s")
        return self.returncode

    def send_signal(self, number):
        """Send a signal to the node, unless it has ended."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self):
        """End it at once, unless it has ended."""
        if self.poll() is None:
            self._process.kill()


def _run(module, arguments, log, environment):
    """Be a node: what `python -m` does, with the imports already made."""
    os.environ.update(environment)
    with Path(log).open("wb", buffering=0) as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    import_module(module).main([module, *arguments])
