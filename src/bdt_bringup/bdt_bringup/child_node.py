"""Runs a node's main and ends it with the process that started it.

``python -m bdt_bringup.child_node PARENT_PID MODULE [ARGUMENT ...]``. When `bdt run` is
killed the kernel ends its nodes, so that no orphan keeps the ROS domain busy.
"""

import ctypes
import os
import signal
import sys
from importlib import import_module

_PR_SET_PDEATHSIG = 1


def main() -> None:
    """Tie this process to its parent and run the node."""
    parent, module, *arguments = sys.argv[1:]
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
        if os.getppid() != int(parent):
            sys.exit("the process that started this node is gone")
    import_module(module).main([sys.argv[0], *arguments])


if __name__ == "__main__":
    main()
