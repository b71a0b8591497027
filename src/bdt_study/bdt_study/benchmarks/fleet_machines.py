"""Machines that send telemetry to a fleet's twins: ``... WARM_UP DURATION NAMESPACE ...``.

Prints a line of JSON: for each twin its largest lag and the number of its estimates, as its
diagnostics tell them, from when all twins have a full window on.
"""

import json
import sys
import time
from typing import Any

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Float64MultiArray

from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import DIAGNOSTICS, TELEMETRY, TELEMETRY_COLUMNS, TWIN_NODE
from bdt_msgs_py.writing import sample_message
from bdt_study.simulation.closed_loop import Scenario, simulate

WINDOW = 20.0
"""Telemetry that each twin gets at first, the window of its estimator [s]."""
PATIENCE = 120.0
"""Wall time in which all twins are to come [s]."""
BATCH = 0.1
"""Time covered by each message after it [s]."""


class Machines:
    """Publishers of the machines, and a listener to their twins.

    Parameters
    ----------
    node : rclpy.node.Node
        Node that has both.
    names : list of str
        Namespaces of the machines.
    """

    def __init__(self, node: Node, names: list[str]) -> None:
        self._publishers = [
            node.create_publisher(
                Float64MultiArray, f"/{name}/{TELEMETRY.name}", qos_profile(TELEMETRY)
            )
            for name in names
        ]
        self._said: dict[str, list[dict[str, str]]] = {f"/{name}/{TWIN_NODE}": [] for name in names}
        self._sent = 0.0
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(node)
        node.create_subscription(
            DiagnosticArray, DIAGNOSTICS.name, self._hear, qos_profile(DIAGNOSTICS)
        )

    def wait_for_twins(self) -> None:
        """Return when each machine has a twin; end the process if one never comes."""
        latest = time.monotonic() + PATIENCE
        while not all(publisher.get_subscription_count() for publisher in self._publishers):
            if time.monotonic() > latest:
                sys.exit(f"machines without a twin after {PATIENCE:g} s")
            self._executor.spin_once(timeout_sec=BATCH)

    def send(self, warm_up: float, duration: float) -> None:
        """Send a window at once and then in real time, machines one after the other.

        Parameters
        ----------
        warm_up : float
            Time after the window before anything counts [s].
        duration : float
            Time that counts [s].
        """
        loop = simulate(Scenario(WINDOW + warm_up + duration), ("u", "q3"))
        rows = np.stack([loop.t, loop.u, loop.q3], axis=1)
        rate, self._sent = round(1.0 / loop.t[1]), float(loop.t[-1])
        window, batch = round(WINDOW * rate), round(BATCH * rate)
        self._publish(rows[:window])
        begin = time.monotonic()
        for number, first in enumerate(range(window, len(rows), batch)):
            self._spin_until(begin + number * BATCH)
            if number == round(warm_up / BATCH):
                for said in self._said.values():
                    said.clear()
            self._publish(rows[first : first + batch])

    def result(self) -> dict[str, Any]:
        """Return the largest lag [s] and the number of estimates of each twin."""
        lags, estimates = [], []
        for said in self._said.values():
            # One that says nothing is behind all that was sent.
            told = (float(one["telemetry_lag_s"]) for one in said)
            lags.append(max(told, default=self._sent))
            counts = [int(one["estimates"]) for one in said] or [0]
            estimates.append(counts[-1] - counts[0])
        return {"lags": lags, "estimates": estimates}

    def _publish(self, rows: Any) -> None:
        message = sample_message(rows, TELEMETRY_COLUMNS)
        for publisher in self._publishers:
            publisher.publish(message)

    def _spin_until(self, due: float) -> None:
        while (left := due - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def _hear(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name in self._said:
                self._said[status.name].append({each.key: each.value for each in status.values})


def main() -> None:
    """Send the telemetry of the machines that the command line names."""
    warm_up, duration, *names = sys.argv[1:]
    rclpy.init()
    node = Node("machines", start_parameter_services=False)
    try:
        machines = Machines(node, names)
        machines.wait_for_twins()
        machines.send(float(warm_up), float(duration))
        print(json.dumps(machines.result()), flush=True)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
