"""The processes of a fleet: started, watched, started anew when they die, stopped."""

import json
import sys
import time
from collections.abc import Sequence

from bdt_bringup.fleet_plan import FleetTwin
from bdt_bringup.node_process import start_guarded, stop_all
from bdt_bringup.restart_policy import MOST_RESTARTS, PERIOD, RestartPolicy
from bdt_msgs_py.command_errors import BAD_INPUT, FAILED, complain
from bdt_msgs_py.process_end import ProcessEnd
from bdt_msgs_py.stop_signals import StopSignals

LOOK = 0.1
"""Wall time [s] between two looks at the processes."""


class FleetProcess:
    """A process with some of the twins, in place of which a new one comes when it dies.

    Parameters
    ----------
    twins : sequence of FleetTwin
        Its twins.
    """

    def __init__(self, twins: Sequence[FleetTwin]) -> None:
        self._twins = twins
        self._policy = RestartPolicy()
        self._due: float | None = None
        self.given_up: int | None = None
        self._start()

    def look(self, now: float) -> None:
        """Plan a new start if the process has died, and start it when that is due.

        Parameters
        ----------
        now : float
            Wall time [s], of any origin.

        Notes
        -----
        `given_up` is the exit code from then on when there will be no new start.
        """
        if self._due is not None:
            if self._due <= now:
                self._start()
            return
        code = self._process.poll()
        if code is None or self.given_up is not None:
            return
        if code == BAD_INPUT:
            # It has said so: no start would change it.
            self.given_up = BAD_INPUT
            return
        names = ", ".join(twin.name for twin in self._twins)
        delay = self._policy.died(now)
        if delay is None:
            self.given_up = complain(
                f"{names}: ended (after {MOST_RESTARTS} restarts within {PERIOD:g} s), is given up",
                FAILED,
            )
            return
        self._due = now + delay
        print(
            f"{names}: the process ended with code {code}, is started anew in {delay:g} s",
            file=sys.stderr,
        )

    def interrupt(self) -> None:
        """Ask the process to end."""
        self._end.ask()

    def stop(self) -> None:
        """End the process, with more force as time goes by."""
        self._end.wait()

    def _start(self) -> None:
        self._due = None
        twins = json.dumps([(twin.namespace, twin.arguments) for twin in self._twins])
        self._process = start_guarded(["bdt_bringup.fleet_worker", twins])
        self._end = ProcessEnd(self._process)


def run_fleet(shares: Sequence[Sequence[FleetTwin]]) -> int:
    """Run a fleet until Ctrl-C, SIGTERM, or until none of its twins is left.

    Parameters
    ----------
    shares : sequence of sequence of FleetTwin
        Twins of each process; see :func:`bdt_bringup.fleet_plan.shared_out`.

    Returns
    -------
    int
        Exit code: 0 after a signal, 2 if all twins refused their parameters, else 1.
    """
    with StopSignals() as signals:
        processes = [FleetProcess(share) for share in shares]
        try:
            while not signals.requested:
                for process in processes:
                    process.look(time.monotonic())
                ends = [process.given_up for process in processes]
                if None not in ends:
                    return BAD_INPUT if set(ends) == {BAD_INPUT} else FAILED
                time.sleep(LOOK)
        finally:
            stop_all(processes)
    return 0
