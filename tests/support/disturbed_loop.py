"""The whole loop in process with a stranger in it, who sends what does not belong."""

import contextlib
import math
from collections import Counter
from importlib import import_module
from typing import Any

import numpy as np
from rclpy.node import Node
from rclpy.serialization import serialize_message
from stray_messages import Stray

from bdt_bags.recorder.recorder_node import RecorderNode
from bdt_bringup.monitor import MonitorNode
from bdt_controller.controller_node import ControllerNode
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_stamp, read_samples
from bdt_msgs_py.topics import (
    ALL_TOPICS,
    DIAGNOSTICS,
    MEASUREMENT,
    REFERENCE,
    TELEMETRY,
    TELEMETRY_COLUMNS,
)
from bdt_msgs_py.writing import platform_position
from bdt_plant.plant_node import PlantNode
from bdt_twin.twin_node import TwinNode

REFERENCE_POSITION = 2e-3
NODES = ("plant", "controller", "twin", "recorder", "bdt run")


def message_class(message_type: str) -> Any:
    """Return the class of a ROS message type."""
    package, _, name = message_type.split("/")
    return getattr(import_module(f"{package}.msg"), name)


class DisturbedLoop:
    """Plant in lockstep, controller, twin, recorder, monitor of ``bdt run``, and a stranger.

    Parameters
    ----------
    ros : RosLoop
        Context and executor.
    bag : Path
        Folder of the recorder's bag.
    duration : float
        Simulated time of the run [s].
    voltage, position : float
        Limits of the plant's hardware [V] and [m].
    reference : str
        ``square``, or ``topic`` for one that a node of its own publishes.
    """

    def __init__(
        self, ros: Any, bag: Any, duration: float, voltage: float, position: float, reference: str
    ) -> None:
        self.ros = ros
        self.diagnostics: list[Any] = []
        self.telemetry: list[Any] = []
        self._genuine: dict[str, Any] = {}
        self._arrived: Counter[str] = Counter()
        self._sent: set[bytes] = set()
        self.stranger = ros.create(Node, "stranger")
        self._publishers: dict[str, Any] = {}
        for topic in ALL_TOPICS:
            self.stranger.create_subscription(
                message_class(topic.message_type),
                topic.name,
                lambda message, name=topic.name: self._note(name, message),
                qos_profile(topic),
            )
        self._operator = ros.create(Node, "operator")
        controller = ros.create(
            ControllerNode, use_sim_time=True, reference__kind=reference, reference__step_time=4.0
        )
        if reference == "topic":
            kind = message_class(REFERENCE.message_type)
            publisher = self._operator.create_publisher(
                kind, REFERENCE.name, qos_profile(REFERENCE)
            )
            publisher.publish(platform_position(0, REFERENCE_POSITION))
            ros.spin_until(lambda: controller._reference_position is not None)
        self.monitor = ros.create(MonitorNode)
        twin = ros.create(TwinNode, use_sim_time=True, communication_delay=0.3)
        recorder = ros.create(RecorderNode, bag=str(bag))
        self.plant = ros.create(
            PlantNode,
            duration=duration,
            gap__final=0.1,
            gap__growth_time=10.0,
            limits__voltage=voltage,
            limits__position=position,
            lockstep_followers=["twin", "recorder"],
        )
        self.nodes = {
            "plant": self.plant,
            "controller": controller,
            "twin": twin,
            "recorder": recorder,
        }

    def _note(self, name: str, message: Any) -> None:
        if bytes(serialize_message(message)) in self._sent:
            return
        self._arrived[name] += 1
        self._genuine[name] = message
        if name == TELEMETRY.name:
            with contextlib.suppress(ValueError):
                self.telemetry.append(read_samples(message, TELEMETRY_COLUMNS).copy())
        elif name == DIAGNOSTICS.name:
            self.diagnostics += message.status

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.plant._simulator.time

    def run_until(self, time: float) -> None:
        """Let the loop run to a simulated time [s]."""
        self.ros.spin_until(lambda: self.time >= time or self.plant.finished.done(), 60.0)

    def finish(self) -> None:
        """Let the loop run to its end, until what was said last is heard."""
        self.ros.result(self.plant.finished, 60.0)
        last = self.time - 0.002
        self.ros.spin_until(lambda: self.telemetry and self.telemetry[-1][-1, 0] >= last)
        told = len(self.diagnostics)
        self.ros.spin_until(
            lambda: {status.name for status in self.diagnostics[told:]} >= {"/plant", "/twin"}
        )

    def disturb(self, stray: Stray) -> dict[str, str]:
        """Send a stray and return what each node did about it."""
        name = stray.topic.name
        if stray.topic is not DIAGNOSTICS:
            self.ros.spin_until(lambda: name in self._genuine)
        publisher = self._publisher(stray)
        before = self._rejected(stray)
        for _ in range(stray.count):
            arrived = self._arrived[name]
            if not stray.topic.reliable:
                # Right after a genuine one, so that the next one does not take its place.
                self.ros.spin_until(lambda: self._arrived[name] > arrived)  # noqa: B023
            now = nanoseconds_from_stamp(self._genuine[MEASUREMENT.name].header.stamp)
            message = stray.build(self._genuine.get(name), now)
            self._sent.add(bytes(serialize_message(message)))
            publisher.publish(message)
            if stray.count > 1:
                self.ros.spin_until(lambda: self._arrived[name] > arrived)  # noqa: B023
        self.run_until(self.time + 0.2)
        return {
            node: self._reaction(node, stray, count - before[node])
            for node, count in self._rejected(stray).items()
        }

    def _publisher(self, stray: Stray) -> Any:
        topic = stray.topic
        if topic.name not in self._publishers:
            # A plant does not bear another publisher of its clock for long.
            for publisher in self._publishers.values():
                self.stranger.destroy_publisher(publisher)
            self._publishers.clear()
            publisher = self.stranger.create_publisher(
                message_class(topic.message_type), topic.name, qos_profile(topic)
            )
            listeners = self.stranger.count_subscribers(topic.name)
            self.ros.spin_until(lambda: publisher.get_subscription_count() >= listeners)
            self._publishers[topic.name] = publisher
        return self._publishers[topic.name]

    def _rejected(self, stray: Stray) -> dict[str, Counter[str]]:
        """Return what each node has rejected of the stray's topic, by reason."""
        counts = {
            name: node._admission._rejected.by_reason(stray.topic)
            for name, node in self.nodes.items()
        }
        return counts | {"bdt run": self.monitor.rejected.by_reason(stray.topic)}

    def _reaction(self, node: str, stray: Stray, rejected: Counter[str]) -> str:
        taken = "recorded" if node == "recorder" else ""
        if rejected:
            reasons = ", ".join(sorted(rejected))
            return f"{taken}, rejected: {reasons}".lstrip(", ")
        if taken:
            return taken
        owner = self.monitor if node == "bdt run" else self.nodes[node]
        name = stray.topic.name if stray.topic.name.startswith("/") else f"/{stray.topic.name}"
        takes = any(one.topic_name == name for one in owner.subscriptions)
        return "accepted" if takes else "not subscribed"

    def samples(self, end: float = math.inf) -> Any:
        """Return rows of (t [s], applied voltage [V], q3 [m]) before a time [s]."""
        rows = np.concatenate(self.telemetry)
        return rows[rows[:, 0] < end]

    def diagnostics_of(self, node: str) -> dict[str, str]:
        """Return what a node said of itself last."""
        last = [status for status in self.diagnostics if status.name == f"/{node}"][-1]
        return {value.key: value.value for value in last.values}
