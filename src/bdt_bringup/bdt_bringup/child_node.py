"""Runs a node's main and ends it with the process that started it.

``python -m bdt_bringup.child_node PARENT_PID MODULE [ARGUMENT ...]``. When `bdt run` is
killed the kernel ends its nodes, so that no orphan keeps the ROS domain busy.
"""

import ctypes
import os
import signal
import sys
from importlib import import_module
from types import ModuleType

_PR_SET_PDEATHSIG = 1


def main() -> None:
    """Tie this process to its parent and run the node."""
    parent, module, *arguments = sys.argv[1:]
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
        if os.getppid() != int(parent):
            sys.exit("the process that started this node is gone")
    run = _import_quietly(module).main
    run([sys.argv[0], *arguments])


def _import_quietly(module: str) -> ModuleType:
    """Import a module; one that is interrupted meanwhile ends without a word."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    imported = import_module(module)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    return imported


if __name__ == "__main__":
    main()
