"""Bags for the tests, built with rosbags: synthetic signals and a short run of the real cores."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from bdt_controller.control_law import INITIAL_CONTROL, control_step, discretize_control
from bdt_controller.pid import PidGains
from bdt_controller.reference import ReferenceProfile, reference_at
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    CLOCK,
    COMMAND,
    DEAD_ZONE_JOINT,
    DEAD_ZONE_PARAMETER,
    DIAGNOSTICS,
    GAP_AGE_JOINT,
    GAP_JOINT,
    GAP_UNCERTAINTY_JOINT,
    MEASUREMENT,
    MOTOR_JOINT,
    PARAMETER_EVENTS,
    PLATFORM_JOINT,
    REFERENCE,
    TELEMETRY,
    TELEMETRY_COLUMNS,
    TRUTH,
    TRUTH_COLUMNS,
    VOLTAGE_OFFSET_JOINT,
    Topic,
)
from bdt_plant.gap_profile import GapProfile
from bdt_plant.lead_screw import LeadScrewParameters
from bdt_plant.plant import PlantModel, Sampling
from bdt_plant.plant_simulator import PlantSimulator
from bdt_plant.sensor import IDEAL_SENSOR, SensorParameters
from bdt_twin.dead_zone_tolerance import tolerance_for_gap
from bdt_twin.inverse_filter import InverseFilterEstimator, InverseFilterSettings

STORE = get_typestore(Stores.ROS2_JAZZY)
WALL_START = 1_800_000_000_000_000_000
"""Receive time [ns] at which the built recordings begin."""


def ros(message_type: str, /, **values):
    return STORE.types[message_type](**values)


def nanoseconds(seconds: float) -> int:
    return round(seconds * 1e9)


def stamp(seconds: float):
    sec, nanosec = divmod(nanoseconds(seconds), 1_000_000_000)
    return ros("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec)


def joint_state(joint: str, time: float, *, position=(), effort=()):
    return ros(
        "sensor_msgs/msg/JointState",
        header=ros("std_msgs/msg/Header", stamp=stamp(time), frame_id=""),
        name=[joint],
        position=np.array(position, dtype=np.float64),
        velocity=np.empty(0),
        effort=np.array(effort, dtype=np.float64),
    )


def samples(rows: np.ndarray, columns: Iterable[str]):
    count, width = rows.shape
    dimension = "std_msgs/msg/MultiArrayDimension"
    layout = ros(
        "std_msgs/msg/MultiArrayLayout",
        dim=[
            ros(dimension, label="sample", size=count, stride=count * width),
            ros(dimension, label=",".join(columns), size=width, stride=width),
        ],
        data_offset=0,
    )
    return ros("std_msgs/msg/Float64MultiArray", layout=layout, data=rows.ravel())


def parameter_event(node: str, time: float, name: str, value: float, *, initial: bool):
    empty = np.empty(0)
    parameter = ros(
        "rcl_interfaces/msg/Parameter",
        name=name,
        value=ros(
            "rcl_interfaces/msg/ParameterValue",
            type=3,
            bool_value=False,
            integer_value=0,
            double_value=value,
            string_value="",
            byte_array_value=empty.astype(np.uint8),
            bool_array_value=empty.astype(np.bool_),
            integer_array_value=empty.astype(np.int64),
            double_array_value=empty,
            string_array_value=[],
        ),
    )
    return ros(
        "rcl_interfaces/msg/ParameterEvent",
        stamp=stamp(time),
        node=node,
        new_parameters=[parameter] if initial else [],
        changed_parameters=[] if initial else [parameter],
        deleted_parameters=[],
    )


def diagnostics(node: str, time: float, values: dict[str, str]):
    status = ros(
        "diagnostic_msgs/msg/DiagnosticStatus",
        level=0,
        name=node,
        message="",
        hardware_id="",
        values=[ros("diagnostic_msgs/msg/KeyValue", key=k, value=v) for k, v in values.items()],
    )
    header = ros("std_msgs/msg/Header", stamp=stamp(time), frame_id="")
    return ros("diagnostic_msgs/msg/DiagnosticArray", header=header, status=[status])


@dataclass
class Messages:
    """Messages of a bag to be: (topic name, type, time of reception in run time [s], message)."""

    items: list[tuple[str, str, float, object]] = field(default_factory=list)
    namespace: str = ""

    def add(self, topic: Topic, received: float, message: object) -> None:
        absolute = topic.name.startswith("/")
        name = topic.name if absolute else f"{self.namespace}/{topic.name}"
        self.items.append((name, topic.message_type, received, message))

    def without(self, *topics: Topic) -> "Messages":
        names = {topic.name.rpartition("/")[2] for topic in topics}
        kept = [item for item in self.items if item[0].rpartition("/")[2] not in names]
        return Messages(kept, self.namespace)

    def telemetry(self, rows: np.ndarray, batch: int) -> None:
        for start in range(0, len(rows), batch):
            part = rows[start : start + batch]
            self.add(TELEMETRY, part[-1, 0], samples(part, TELEMETRY_COLUMNS))

    def reference(self, time: float, position: float, received: float | None = None) -> None:
        message = joint_state(PLATFORM_JOINT, time, position=[position])
        self.add(REFERENCE, time if received is None else received, message)

    def estimate(
        self,
        time: float,
        gap: float,
        uncertainty: float | None = None,
        *,
        age: float | None = None,
        tolerance: float | None = None,
        voltage_offset: float | None = None,
    ) -> None:
        """Add an estimate with the joints that are given: any may be missing but the gap."""
        joints = {
            GAP_JOINT: gap,
            GAP_UNCERTAINTY_JOINT: uncertainty,
            GAP_AGE_JOINT: age,
            DEAD_ZONE_JOINT: tolerance,
            VOLTAGE_OFFSET_JOINT: None if voltage_offset is None else 0.0,
        }
        told = {joint: value for joint, value in joints.items() if value is not None}
        message = joint_state(GAP_JOINT, time, position=list(told.values()))
        message.name = list(told)
        if voltage_offset is not None:
            message.effort = np.array([0.0] * (len(told) - 1) + [voltage_offset])
        self.add(BACKLASH_ESTIMATE, time, message)

    def parameter(
        self,
        time: float,
        node: str,
        name: str,
        value: float,
        *,
        initial: bool = False,
        received: float | None = None,
    ) -> None:
        event = parameter_event(node, time, name, value, initial=initial)
        self.add(PARAMETER_EVENTS, time if received is None else received, event)

    def dead_zone(self, time: float, value: float, **options) -> None:
        self.parameter(time, f"{self.namespace}/controller", DEAD_ZONE_PARAMETER, value, **options)

    store = STORE
    rows_message = staticmethod(samples)
    joint_message = staticmethod(joint_state)

    def diagnosed_dead_zone(self, time: float, value: float) -> None:
        message = diagnostics(
            f"{self.namespace}/controller", 0.0, {f"{DEAD_ZONE_PARAMETER}_m": str(value)}
        )
        self.add(DIAGNOSTICS, time, message)

    def write(
        self,
        path: Path,
        *,
        storage: StoragePlugin = StoragePlugin.MCAP,
        compression: CompressionMode = CompressionMode.NONE,
        pace: float = 4.0,
        empty: Iterable[Topic] = (),
    ) -> Path:
        """Write a bag: `pace` is its real-time factor, `empty` are topics without messages."""
        writer = Writer(path, version=9, storage_plugin=storage)
        writer.set_compression(compression, CompressionFormat.ZSTD)
        with writer:
            connections = {}
            for topic in empty:
                name = f"/{topic.name}"
                connections[name] = writer.add_connection(name, topic.message_type, typestore=STORE)
            for name, message_type, received, message in sorted(self.items, key=lambda x: x[2]):
                if name not in connections:
                    connections[name] = writer.add_connection(name, message_type, typestore=STORE)
                data = (
                    message
                    if isinstance(message, bytes)
                    else STORE.serialize_cdr(message, message_type)
                )
                first = min(item[2] for item in self.items[:1])
                arrival = WALL_START + nanoseconds((received - first) / pace)
                writer.write(connections[name], arrival, data)
        return path


@dataclass(frozen=True)
class Loop:
    """A closed loop without nodes: what to run and how often messages come."""

    duration: float = 20.0
    step_time: float = 5.0
    amplitude: float = 5e-3
    final_gap: float = np.deg2rad(30.0)
    dead_zone: float | None = None
    """Constant dead zone [m]; None lets the twin set it."""
    delay: float = 0.5
    sampling_rate: float = 5000.0
    control_rate: float = 500.0
    batch_time: float = 0.1
    namespace: str = ""
    sensor: SensorParameters = IDEAL_SENSOR


def run_loop(loop: Loop) -> Messages:
    """Run plant, controller and estimator and return the messages that the nodes would send."""
    profile = GapProfile(final=loop.final_gap, growth_time=loop.duration, exponent=1.0)
    sampling = Sampling(sampling_rate=loop.sampling_rate, control_rate=loop.control_rate)
    plant = PlantSimulator(PlantModel(), profile, sampling, loop.sensor)
    estimator = InverseFilterEstimator(
        PlantModel(), InverseFilterSettings(sampling_rate=loop.sampling_rate)
    )
    law, state = discretize_control(PidGains(), 1 / loop.control_rate), INITIAL_CONTROL
    reference = ReferenceProfile(first=loop.amplitude, step_time=loop.step_time)
    pitch = LeadScrewParameters().pitch
    messages = Messages(namespace=loop.namespace)
    dead_zone, target = loop.dead_zone or 0.0, None
    messages.dead_zone(0.0, dead_zone, initial=True)
    rows, truth, pending = [], [], []
    for step in range(round(loop.duration * loop.control_rate)):
        time = plant.time
        if pending and pending[0][0] <= time + 1e-9:
            _, dead_zone = pending.pop(0)
            messages.dead_zone(time, dead_zone)
        if reference_at(reference, time) != target:
            target = reference_at(reference, time)
            messages.reference(time, target)
        position = plant.position
        messages.add(MEASUREMENT, time, joint_state(PLATFORM_JOINT, time, position=[position]))
        state, voltage = control_step(state, target - position, dead_zone, law)
        messages.add(COMMAND, time, joint_state(MOTOR_JOINT, time, effort=[voltage]))
        truth.append(plant.truth())
        rows.append(plant.advance(voltage))
        if (step + 1) % round(loop.batch_time * loop.control_rate) == 0:
            batch, truths = np.concatenate(rows), np.array(truth)
            messages.add(TELEMETRY, plant.time, samples(batch, TELEMETRY_COLUMNS))
            messages.add(TRUTH, plant.time, samples(truths, TRUTH_COLUMNS))
            clock = ros("rosgraph_msgs/msg/Clock", clock=stamp(plant.time))
            messages.add(CLOCK, plant.time, clock)
            for found in estimator.estimates(batch[:, 1], batch[:, 2]):
                messages.estimate(found.sample / loop.sampling_rate, found.gap)
                if loop.dead_zone is None:
                    due = plant.time + loop.delay
                    pending.append((due, tolerance_for_gap(found.gap, pitch)))
            rows.clear()
            truth.clear()
    return messages


@pytest.fixture(scope="session")
def following_loop() -> Messages:
    """Return the messages of a loop whose dead zone follows the gap."""
    return run_loop(Loop())


@pytest.fixture(scope="session")
def linear_loop() -> Messages:
    """Return the messages of a loop without a dead zone."""
    return run_loop(Loop(dead_zone=0.0))


@pytest.fixture(scope="session")
def small_loop() -> Messages:
    """Return the messages of two seconds at low rates."""
    return run_loop(Loop(duration=2.0, step_time=1.0, sampling_rate=500.0, control_rate=50.0))


@pytest.fixture(scope="session")
def shortest_loop() -> Messages:
    """Return the messages of 0.6 s at low rates, with every topic that the analysis reads."""
    messages = run_loop(Loop(duration=0.6, step_time=0.2, sampling_rate=500.0, control_rate=50.0))
    messages.diagnosed_dead_zone(0.1, 1e-5)
    return messages


@pytest.fixture(scope="session")
def following_bag(following_loop: Messages, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return following_loop.write(tmp_path_factory.mktemp("following") / "bag")


@pytest.fixture(scope="session")
def linear_bag(linear_loop: Messages, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return linear_loop.write(tmp_path_factory.mktemp("linear") / "bag")


@pytest.fixture
def loop_messages() -> Callable[..., Messages]:
    """Return a function that runs a loop with given fields of :class:`Loop`."""
    return lambda **fields: run_loop(Loop(**fields))


@pytest.fixture
def signal_messages() -> Callable[..., Messages]:
    """Return a function that makes the messages of a given q3 with given steps."""

    def make(time, position, steps, *, batch: int = 100) -> Messages:
        messages = Messages()
        messages.telemetry(np.stack([time, np.zeros_like(time), position], axis=1), batch)
        for start, value in steps:
            messages.reference(start, value)
        return messages

    return make
