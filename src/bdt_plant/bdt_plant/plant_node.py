"""Plant simulator as a ROS 2 node, in lockstep with its controller or in real time."""

import math
import sys
from typing import Any

import numpy as np
from rclpy.clock import Clock as RosClock
from rclpy.clock import ClockType
from rclpy.node import Node
from rclpy.task import Future
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, TimeReference
from std_msgs.msg import Float64MultiArray

from bdt_msgs_py.diagnostics import DiagnosticsPublisher, Health
from bdt_msgs_py.exit_codes import LoopError
from bdt_msgs_py.node_main import run_node
from bdt_msgs_py.node_parameters import declare_all
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_seconds, nanoseconds_from_stamp, read_voltage
from bdt_msgs_py.topics import (
    CLOCK,
    COMMAND,
    MEASUREMENT,
    PLANT_NODE,
    PROGRESS,
    TELEMETRY,
    TELEMETRY_COLUMNS,
    TRUTH,
    TRUTH_COLUMNS,
)
from bdt_msgs_py.writing import platform_position, sample_message, stamp_from_nanoseconds
from bdt_plant.compiled_period import compiled_hold_period
from bdt_plant.lockstep import Followers
from bdt_plant.parameters import PARAMETERS
from bdt_plant.plant import PlantModel, hold_period
from bdt_plant.plant_simulator import PlantSimulator

LONG_RUN = 10.0
"""Simulated time [s] from which loading the compiled plant takes less time than it saves."""


class PlantNode(Node):
    """Simulates the mechanism: publishes measurements, takes commands, owns simulated time.

    Parameters
    ----------
    **node_arguments
        Passed on to :class:`rclpy.node.Node`, for example ``context`` or ``parameter_overrides``.

    Attributes
    ----------
    finished : rclpy.task.Future
        Done when ``duration`` is over, or with a :class:`LoopError` when lockstep cannot go on.

    Raises
    ------
    ConfigurationError
        For a parameter that is unknown or not allowed.
    """

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__(PLANT_NODE, **node_arguments)
        self._settings, self._sampling, *constants, profile, actuator, sensor = declare_all(
            self, PARAMETERS
        )
        model = PlantModel(*constants)
        self.finished: Future[None] = Future()
        duration = self._settings.duration
        is_long = not duration or duration >= LONG_RUN
        self._simulator = PlantSimulator(
            model,
            profile,
            self._sampling,
            sensor,
            actuator,
            compiled_hold_period() if is_long else hold_period,
        )
        self._followers = Followers(self._settings.lockstep_followers)
        samples = max(round(duration * self._sampling.sampling_rate), 1)
        self._end = samples if duration else math.inf
        self._telemetry: list[np.ndarray] = []
        self._truth: list[tuple[float, ...]] = []
        control_rate = self._sampling.control_rate
        self._batch_steps = max(round(self._settings.telemetry_period * control_rate), 1)
        self._clock_steps = max(round(control_rate / self._settings.clock_rate), 1)
        self._control_step = 0
        self._voltage, self._voltage_stamp = 0.0, -1
        self._rejected_commands = self._resent = self._stale_steps = 0
        self._reported_troubles = 0

        self._measurement_publisher = self._topic_publisher(JointState, MEASUREMENT)
        self._telemetry_publisher = self._topic_publisher(Float64MultiArray, TELEMETRY)
        self._truth_publisher = self._topic_publisher(Float64MultiArray, TRUTH)
        self._clock_publisher = self._topic_publisher(Clock, CLOCK)
        self._diagnostics = DiagnosticsPublisher(self, self._health)

        steady = RosClock(clock_type=ClockType.STEADY_TIME)
        if self._settings.mode == "realtime":
            self._on_command = self._keep_command
            self.create_timer(1.0 / control_rate, self._realtime_step, clock=steady)
        else:
            self._on_command = self._advance_with_command
            self._steady = steady
            self._last_event = steady.now().nanoseconds
            self._waiting_for_command = False
            self.create_subscription(
                TimeReference, PROGRESS.name, self._take_progress, qos_profile(PROGRESS)
            )
            self.create_timer(self._settings.resend_period, self._watch_lockstep, clock=steady)
        self.create_subscription(JointState, COMMAND.name, self._take_command, qos_profile(COMMAND))

    def _topic_publisher(self, message_type: Any, topic: Any) -> Any:
        return self.create_publisher(message_type, topic.name, qos_profile(topic))

    # Commands ------------------------------------------------------------------------------

    def _take_command(self, message: JointState) -> None:
        try:
            stamp, voltage = read_voltage(message)
        except ValueError as error:
            self._reject_command(str(error))
            return
        if not math.isfinite(voltage):
            self._reject_command(f"motor voltage {voltage} V: must be finite")
            return
        self._on_command(stamp, voltage)

    def _reject_command(self, reason: str) -> None:
        self._rejected_commands += 1
        self.get_logger().warning(f"rejected a command: {reason}", throttle_duration_sec=1.0)

    def _advance(self, voltage: float) -> None:
        """Advance to the next measurement and publish what is due."""
        self._truth.append(self._simulator.truth())
        self._telemetry.append(self._simulator.advance(voltage))
        self._control_step += 1
        if len(self._telemetry) == self._batch_steps or self._simulator.sample >= self._end:
            self._publish_batch()

    def _publish_batch(self) -> None:
        rows = np.concatenate(self._telemetry)
        self._telemetry_publisher.publish(sample_message(rows, TELEMETRY_COLUMNS))
        self._truth_publisher.publish(sample_message(np.array(self._truth), TRUTH_COLUMNS))
        self._followers.telemetry_published(nanoseconds_from_seconds(rows[-1, 0]))
        self._telemetry.clear()
        self._truth.clear()

    def _publish_clock(self) -> None:
        self._clock_publisher.publish(
            Clock(clock=stamp_from_nanoseconds(self._simulator.nanoseconds))
        )

    def _publish_measurement(self) -> None:
        simulator = self._simulator
        self._measurement_publisher.publish(
            platform_position(simulator.nanoseconds, simulator.position)
        )

    # Lockstep ------------------------------------------------------------------------------

    def _advance_with_command(self, stamp: int, voltage: float) -> None:
        if not self._waiting_for_command or stamp != self._simulator.nanoseconds:
            return  # the answer to a measurement that was sent twice
        self._waiting_for_command = False
        self._advance(voltage)
        self._proceed()

    def _take_progress(self, message: TimeReference) -> None:
        known = self._followers.progress(
            message.source,
            nanoseconds_from_stamp(message.header.stamp),
            nanoseconds_from_stamp(message.time_ref),
        )
        if known and not self._waiting_for_command and self._control_step:
            self._proceed()

    def _proceed(self) -> None:
        """Publish the next measurement, unless the end or a follower is in the way."""
        self._last_event = self._steady.now().nanoseconds
        holding = self._holding()
        if holding or self._control_step % self._clock_steps == 0:
            self._publish_clock()
        if holding or self.finished.done():
            return
        if self._simulator.sample >= self._end:
            self.finished.set_result(None)
            return
        self._waiting_for_command = True
        self._publish_measurement()

    def _holding(self) -> list[str]:
        """Return who is in the way: at the end everybody who has not seen all of the run."""
        at_end = self._simulator.sample >= self._end
        behind = self._followers.behind() if at_end else []
        return behind or self._followers.holding(self._simulator.nanoseconds)

    def _watch_lockstep(self) -> None:
        """Begin, send again what may have been lost, give up when nobody answers any more."""
        silence = (self._steady.now().nanoseconds - self._last_event) * 1e-9
        if self.finished.done() or silence < self._settings.resend_period:
            return
        self._publish_clock()
        awaited = self._awaited()
        if not self._control_step:
            self.get_logger().info(f"waiting for {awaited}", throttle_duration_sec=5.0)
            self._waiting_for_command = self._everybody_is_here()
        elif silence > self._settings.lockstep_timeout:
            self.finished.set_exception(
                LoopError(
                    f"{self.get_fully_qualified_name()} waited {silence:.1f} s for {awaited} at "
                    f"t = {self._simulator.time:g} s (lockstep_timeout "
                    f"{self._settings.lockstep_timeout:g} s)"
                )
            )
            return
        if self._waiting_for_command:
            self._resent += self._control_step > 0
            self._publish_measurement()

    def _awaited(self) -> str:
        holding = self._holding()
        return "progress of " + ", ".join(holding) if holding else f"a {COMMAND.name}"

    def _everybody_is_here(self) -> bool:
        """Tell whether the run can begin without losing the first telemetry."""
        matched = self._telemetry_publisher.get_subscription_count()
        return matched >= len(self._followers) and not self._followers.holding(0)

    # Real time -----------------------------------------------------------------------------

    def _keep_command(self, stamp: int, voltage: float) -> None:
        if stamp >= self._voltage_stamp:
            self._voltage, self._voltage_stamp = voltage, stamp

    def _realtime_step(self) -> None:
        if self.finished.done():
            return
        age = (self._simulator.nanoseconds - self._voltage_stamp) * 1e-9
        fresh = self._voltage_stamp >= 0 and age <= self._settings.command_timeout
        self._stale_steps += not fresh
        self._advance(self._voltage if fresh else 0.0)
        if self._control_step % self._clock_steps == 0:
            self._publish_clock()
        if self._simulator.sample >= self._end:
            self.finished.set_result(None)
            return
        self._publish_measurement()

    # Diagnostics ---------------------------------------------------------------------------

    def _health(self) -> Health:
        troubles = self._rejected_commands + self._stale_steps + self._resent
        well = troubles == self._reported_troubles
        self._reported_troubles = troubles
        values = {
            "mode": self._settings.mode,
            "simulated_time_s": self._simulator.time,
            "control_steps": self._control_step,
            "rejected_commands": self._rejected_commands,
            "steps_without_fresh_command": self._stale_steps,
            "resent_measurements": self._resent,
            "saturated_steps": self._simulator.saturated_steps,
            "dropped_samples": self._simulator.dropped_samples,
        }
        return Health(well, "running" if well else "commands missing, late or not valid", values)


def main(args: list[str] | None = None) -> None:
    """Run the plant node; the console script ``plant_node``."""
    sys.exit(run_node(PlantNode, args))


if __name__ == "__main__":
    main()
