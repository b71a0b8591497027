"""Some twins of a fleet in one process, none of which takes the others with it when it fails.

``python -m bdt_bringup.fleet_worker TWINS``, a JSON list of namespaces with the ROS arguments of
the twin there.
"""

import json
import sys
import threading
import time
import traceback
from collections.abc import Callable, Sequence

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from bdt_bringup.fleet_plan import FleetTwin
from bdt_bringup.installed import node_class
from bdt_bringup.restart_policy import MOST_RESTARTS, PERIOD, RestartPolicy
from bdt_msgs_py.command_errors import BAD_INPUT, FAILED, BadInputError, complain
from bdt_msgs_py.stop_signals import StopSignals
from bdt_msgs_py.topics import TWIN_NODE

LOOK = 0.1
"""Wall time [s] between two looks at signals."""


class HostedTwin(threading.Thread):
    """A twin with a thread and an executor of its own, started anew when it fails.

    What it raises, and a callback that hangs, is its own affair.

    Parameters
    ----------
    twin : FleetTwin
        The twin.
    create : callable
        Returns its node; called with ``context`` and ``cli_args``.
    context : rclpy.context.Context
        Shared by the twins of the process; they end with it.

    Attributes
    ----------
    is_refused : bool
        Whether the node refused its parameters, after which it is not started anew.
    """

    # Nodes are made one after the other: each compiles the same loops.
    _creation = threading.Lock()

    def __init__(self, twin: FleetTwin, create: Callable[..., Node], context: Context) -> None:
        super().__init__(name=twin.name, daemon=True)
        self.is_refused = False
        self._twin, self._create, self._context = twin, create, context
        self._policy = RestartPolicy()
        self._ended = threading.Event()

    def run(self) -> None:
        """Live until the context is shut down, or until the twin is given up."""
        while self._context.ok():
            try:
                self._live()
            except ExternalShutdownException:
                return
            except BadInputError as error:
                complain(f"{self.name}: {error}", BAD_INPUT)
                self.is_refused = True
                return
            # Whatever it is, it must not reach the twins beside this one.
            except BaseException:  # noqa: BLE001
                if not self._context.ok():
                    return
                traceback.print_exc()
            if not self._waits_for_new_start():
                return

    def end(self) -> None:
        """End the wait for a new start; everything else ends with the context."""
        self._ended.set()

    def _live(self) -> None:
        with self._creation:
            node = self._create(
                context=self._context, cli_args=["--ros-args", *self._twin.arguments]
            )
        executor = SingleThreadedExecutor(context=self._context)
        try:
            executor.add_node(node)
            executor.spin()
        finally:
            executor.shutdown()
            node.destroy_node()

    def _waits_for_new_start(self) -> bool:
        delay = self._policy.died(time.monotonic())
        if delay is None:
            again = f"after {MOST_RESTARTS} restarts within {PERIOD:g} s"
            complain(f"{self.name}: failed ({again}), is given up", FAILED)
            return False
        print(f"{self.name}: failed, is started anew in {delay:g} s", file=sys.stderr)
        return not self._ended.wait(delay)


def run_twins(twins: Sequence[FleetTwin]) -> int:
    """Run twins until a signal comes or none is left.

    Parameters
    ----------
    twins : sequence of FleetTwin
        The twins.

    Returns
    -------
    int
        Exit code: 0 after a signal, 2 if all refused their parameters, else 1.
    """
    context = Context()
    try:
        rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:
        return complain(error, BAD_INPUT)
    hosted = [HostedTwin(twin, node_class(TWIN_NODE), context) for twin in twins]
    with StopSignals() as signals:
        for one in hosted:
            one.start()
        while not signals.requested and any(one.is_alive() for one in hosted):
            time.sleep(LOOK)
        context.try_shutdown()
        for one in hosted:
            one.end()
        for one in hosted:
            one.join()
    if signals.requested:
        return 0
    return BAD_INPUT if all(one.is_refused for one in hosted) else FAILED


def main(args: list[str] | None = None) -> None:
    """Run the twins that the command line names."""
    words = sys.argv if args is None else args
    twins = [FleetTwin(namespace, tuple(given)) for namespace, given in json.loads(words[1])]
    sys.exit(run_twins(twins))


if __name__ == "__main__":
    main()
