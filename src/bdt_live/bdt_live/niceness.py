"""How much the processes of `bdt live` let others go first: the loop above all."""

import os

PAGE_NICENESS = 10
"""Of the process behind the page, 0 to 19."""

REPORT_NICENESS = 5
"""Of a report: three busy processes on two processors leave it a fifth of one.

At 19 they leave it a hundredth, and its few seconds take minutes.
"""


def let_others_go_first(process: int, niceness: int) -> None:
    """Make a process nicer; one that is nicer already stays as it is.

    Parameters
    ----------
    process : int
        Its number; 0 for this one.
    niceness : int
        How much it lets others go first, 0 to 19.
    """
    # Only a privileged user may make it less nice.
    before = os.getpriority(os.PRIO_PROCESS, process)
    os.setpriority(os.PRIO_PROCESS, process, max(before, niceness))
