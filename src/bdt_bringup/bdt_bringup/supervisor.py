"""The nodes of a run as processes: started, watched, started anew where that is wanted."""

import sys
import time
from collections import defaultdict

from bdt_bringup.node_process import NodeProcess, stop_all
from bdt_bringup.restart_policy import MOST_RESTARTS, PERIOD, RestartPolicy
from bdt_bringup.run_plan import RunPlan
from bdt_msgs_py.command_errors import BAD_INPUT, BadInputError, LoopError


class Supervisor:
    """Starts the nodes of a plan; the machine, which is the run, is never started anew.

    Parameters
    ----------
    plan : RunPlan
        What to start, and whether nodes that died are started anew.
    """

    def __init__(self, plan: RunPlan) -> None:
        self._plan = plan
        self._modules = plan.modules
        self._logs = plan.output / "log"
        self._logs.mkdir()
        self._running: dict[str, NodeProcess] = {}
        self._policies: defaultdict[str, RestartPolicy] = defaultdict(RestartPolicy)
        self._due: dict[str, float] = {}
        self._lives: defaultdict[str, int] = defaultdict(int)

    def start_all(self) -> None:
        """Start all nodes, the machine last."""
        for name in self._modules:
            self._start(name)

    @property
    def machine(self) -> NodeProcess:
        """The process of the plant, or of the driver of a real machine."""
        return self._running[self._plan.machine]

    def look(self) -> None:
        """Start nodes anew that died.

        Raises
        ------
        BadInputError
            If a node has refused its parameters.
        LoopError
            If a node died and is not started anew.
        """
        now = time.monotonic()
        others = [one for name, one in self._running.items() if name != self._plan.machine]
        ended = [one for one in others if one.exit_code is not None and one.name not in self._due]
        if not self._plan.supervise or any(one.exit_code == BAD_INPUT for one in ended):
            raise_for_ended_node(ended)
        for process in ended:
            self._plan_restart(process, now)
        for name in [name for name, due in self._due.items() if due <= now]:
            del self._due[name]
            self._start(name)

    def stop(self) -> None:
        """Stop all nodes."""
        stop_all(list(self._running.values()))

    def raise_for_failures(self) -> None:
        """Raise for a node that did not end well; see :func:`raise_for_ended_node`."""
        failed = [one for one in self._running.values() if one.exit_code != 0]
        # A node that died waited to be started anew when the run was over.
        raise_for_ended_node([one for one in failed if one.name not in self._due])

    def _start(self, name: str) -> None:
        self._lives[name] += 1
        arguments = self._plan.ros_arguments(name, self._lives[name])
        log = self._logs / f"{name}.log"
        self._running[name] = NodeProcess(name, self._modules[name], arguments, log)

    def _plan_restart(self, process: NodeProcess, now: float) -> None:
        delay = self._policies[process.name].died(now)
        if delay is None:
            text = describe_end(process)
            raise LoopError(f"{text} (after {MOST_RESTARTS} restarts within {PERIOD:g} s)")
        self._due[process.name] = now + delay
        print(f"{describe_end(process)}: is started anew in {delay:g} s", file=sys.stderr)


def describe_end(process: NodeProcess) -> str:
    """Return which node has ended, how, and what it said last, in a line."""
    said = " | ".join(process.last_lines())
    return f"node {process.name}: {process.describe_end()}" + (f": {said}" if said else "")


def raise_for_ended_node(processes: list[NodeProcess]) -> None:
    """Raise for a process that has ended, preferably one that a signal ended.

    A node that dies takes others along: the plant gives up when nobody answers.

    Raises
    ------
    BadInputError
        If it has refused its parameters.
    LoopError
        If it ended otherwise; the text says which one and what it said last.
    """
    ended = [process for process in processes if process.exit_code is not None]
    if not ended:
        return
    culprit = min(ended, key=lambda process: process.exit_code or 0)
    text = describe_end(culprit)
    raise BadInputError(text) if culprit.exit_code == BAD_INPUT else LoopError(text)
