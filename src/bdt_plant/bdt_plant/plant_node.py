"""Plant simulator as a ROS 2 node, in lockstep with its controller or in real time."""

import math
import sys
import time
from typing import Any

import numpy as np
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.task import Future
from sensor_msgs.msg import JointState, TimeReference

from bdt_msgs_py.admission import Admission
from bdt_msgs_py.awaited_commands import AwaitedCommands
from bdt_msgs_py.clock_check import keep_wall_time
from bdt_msgs_py.command_errors import BadInputError, LoopError
from bdt_msgs_py.diagnostics import DiagnosticsPublisher, Health
from bdt_msgs_py.message_checks import VoltageCommand, check_command, check_progress
from bdt_msgs_py.node_main import run_node
from bdt_msgs_py.node_parameters import declare_all
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_seconds
from bdt_msgs_py.rejection import MessageRejectedError
from bdt_msgs_py.topics import CLOCK, COMMAND, MEASUREMENT, PLANT_NODE, PROGRESS, TELEMETRY, TRUTH
from bdt_plant.clock_owner import LOOK_PERIOD, ClockOwner
from bdt_plant.compiled_period import compiled_period_of
from bdt_plant.limits import LimitedDrive
from bdt_plant.lockstep import Followers
from bdt_plant.pace import Pace
from bdt_plant.pace_keeper import PaceKeeper
from bdt_plant.parameters import PARAMETERS
from bdt_plant.plant import PlantModel
from bdt_plant.plant_publishers import PlantPublishers
from bdt_plant.plant_reconfiguration import PlantConfiguration, PlantReconfiguration
from bdt_plant.plant_simulator import PlantSimulator

PATIENCE = 1.0
"""Wall time [s] after which the newest telemetry is sent again to who does not come on."""
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
        Done when ``duration`` is over, or with a :class:`LoopError` when lockstep cannot go on, or
        a :class:`BadInputError` when somebody else publishes the clock.

    Raises
    ------
    ConfigurationError
        For a parameter that is unknown or not allowed.
    """

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__(PLANT_NODE, **node_arguments)
        self._settings, self._sampling, *constants, profile, actuator, sensor, limits = declare_all(
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
            compiled_period_of(model) if is_long else None,
        )
        pace = Pace(self._settings.pace, self._settings.pause_at)
        self._pace = PaceKeeper(self, pace, self._proceed)
        declared = PlantConfiguration(self._settings, model, profile, sensor)
        self._reconfiguration = PlantReconfiguration(self, declared, self._simulator, pace)
        self._followers = Followers(self._settings.lockstep_followers)
        self._commands = AwaitedCommands(self._settings.command_timeout)
        self._drive = LimitedDrive(limits)
        samples = max(round(duration * self._sampling.sampling_rate), 1)
        self._end = samples if duration else math.inf
        self._telemetry: list[np.ndarray] = []
        self._truth: list[tuple[float, ...]] = []
        control_rate = self._sampling.control_rate
        self._batch_steps = max(round(self._settings.telemetry_period * control_rate), 1)
        self._clock_steps = max(round(control_rate / self._settings.clock_rate), 1)
        self._control_step = 0
        self._voltage, self._voltage_stamp = 0.0, -1
        self._resent = self._stale_steps = self._reported_troubles = 0

        self._outputs = PlantPublishers(self)
        sole_publisher = (MEASUREMENT, TELEMETRY, TRUTH, CLOCK, COMMAND)
        self._admission = Admission(self, sole_publisher)
        keep_wall_time(self, "the plant owns the clock")
        self._diagnostics = DiagnosticsPublisher(self, self._health)

        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._clock_owner = ClockOwner(self, self._outputs.clock)
        look_period = min(LOOK_PERIOD, self._settings.resend_period)
        self.create_timer(look_period, self._look_for_other_clocks, clock=steady)
        if self._settings.mode == "realtime":
            self._on_command = self._keep_command
            self.create_timer(1.0 / control_rate, self._realtime_step, clock=steady)
        else:
            self._on_command = self._advance_with_command
            self._last_advance = time.monotonic()
            self._waiting_for_command = False
            self.create_subscription(
                TimeReference, PROGRESS.name, self._take_progress, qos_profile(PROGRESS)
            )
            self.create_timer(self._settings.resend_period, self._watch_lockstep, clock=steady)
        self.create_subscription(JointState, COMMAND.name, self._take_command, qos_profile(COMMAND))

    # Commands ------------------------------------------------------------------------------

    def _take_command(self, message: JointState) -> None:
        try:
            command = check_command(message)
            is_new = self._commands.accept(command, time.monotonic())
        except MessageRejectedError as error:
            self._admission.reject(COMMAND, error)
            return
        if is_new:
            self._on_command(command)

    def _advance(self, voltage: float) -> None:
        """Advance to the next measurement and publish what is due."""
        was_stopped = self._drive.is_stopped
        limited = self._drive.voltage(voltage, self._simulator.position)
        if self._drive.is_stopped and not was_stopped:
            self.get_logger().error(self._drive.stop_reason)
        self._truth.append(self._simulator.truth())
        self._telemetry.append(self._simulator.advance(limited))
        self._control_step += 1
        if len(self._telemetry) == self._batch_steps or self._simulator.sample >= self._end:
            self._publish_batch()

    def _publish_batch(self) -> None:
        rows = np.concatenate(self._telemetry)
        self._outputs.publish_batch(rows, self._truth)
        self._followers.telemetry_published(nanoseconds_from_seconds(rows[-1, 0]))
        self._telemetry.clear()
        self._truth.clear()

    def _publish_measurement(self, *, memory: float = 0.0) -> None:
        """Publish a measurement; those up to `memory` [s] older may still be answered."""
        stamp = self._simulator.nanoseconds
        self._commands.published(stamp, stamp - round(memory * 1e9), time.monotonic())
        self._outputs.publish_measurement(stamp, self._simulator.position)

    def _look_for_other_clocks(self) -> None:
        fault = None if self.finished.done() else self._clock_owner.look()
        if fault:
            self.finished.set_exception(BadInputError(fault))

    # Lockstep ------------------------------------------------------------------------------

    def _advance_with_command(self, command: VoltageCommand) -> None:
        self._waiting_for_command = False
        self._last_advance = time.monotonic()
        self._advance(command.voltage)
        self._proceed()

    def _take_progress(self, message: TimeReference) -> None:
        try:
            known = self._followers.progress(*check_progress(message), time.monotonic())
        except MessageRejectedError as error:
            self._admission.reject(PROGRESS, error)
            return
        if known and not self._waiting_for_command and self._control_step:
            self._proceed()

    def _proceed(self) -> None:
        """Publish the next measurement, unless the end or a follower is in the way."""
        blocking = self._blocking_nodes()
        if blocking or self._control_step % self._clock_steps == 0:
            self._outputs.publish_clock(self._simulator.nanoseconds)
        if blocking or self.finished.done():
            return
        if self._simulator.sample >= self._end:
            self.finished.set_result(None)
            return
        if not self._pace.may_proceed(self._simulator.time):
            return
        self._waiting_for_command = True
        self._last_advance = time.monotonic()
        self._publish_measurement()

    def _blocking_nodes(self) -> list[str]:
        """Return who is in the way: at the end everybody who has not seen all of the run."""
        at_end = self._simulator.sample >= self._end
        lagging = self._followers.lagging() if at_end else []
        return lagging or self._followers.blocking(self._simulator.nanoseconds)

    def _watch_lockstep(self) -> None:
        """Begin, send again what may have been lost, give up when somebody does not come on."""
        now = time.monotonic()
        silence = now - self._last_advance
        if self.finished.done() or silence < self._settings.resend_period:
            return
        if not self._clock_owner.is_established:
            return
        self._outputs.publish_clock(self._simulator.nanoseconds)
        if self._pace.is_holding:
            self._last_advance = now
            return
        blocking = self._blocking_nodes()
        if not self._control_step:
            self.get_logger().info(f"waiting for {_awaited(blocking)}", throttle_duration_sec=5.0)
            self._waiting_for_command = self._everybody_is_here()
        elif silence > self._settings.lockstep_timeout:
            # A node that is slow comes on; one that is gone or hangs does not, whatever it says.
            stuck = self._followers.stuck(blocking, now - self._settings.lockstep_timeout)
            if stuck or not blocking:
                self._give_up(silence, _awaited(stuck))
                return
            text = f"waiting for {_awaited(blocking)}, which is slow"
            self.get_logger().warning(text, throttle_duration_sec=5.0)
        if self._waiting_for_command:
            self._resent += self._control_step > 0
            self._publish_measurement()
        # Who does not come on takes long over the newest telemetry, or has not got it.
        behind = set(blocking).intersection(self._followers.lagging())
        if self._followers.stuck(behind, now - PATIENCE):
            self._outputs.repeat_telemetry(PATIENCE)

    def _give_up(self, silence: float, awaited: str) -> None:
        self.finished.set_exception(
            LoopError(
                f"{self.get_fully_qualified_name()} waited {silence:.1f} s for {awaited} at "
                f"t = {self._simulator.time:g} s (lockstep_timeout "
                f"{self._settings.lockstep_timeout:g} s)"
            )
        )

    def _everybody_is_here(self) -> bool:
        """Tell whether the run can begin without losing the first telemetry."""
        matched = self._outputs.telemetry.get_subscription_count()
        return matched >= len(self._followers) and not self._followers.blocking(0)

    # Real time -----------------------------------------------------------------------------

    def _keep_command(self, command: VoltageCommand) -> None:
        self._voltage, self._voltage_stamp = command.voltage, command.stamp

    def _realtime_step(self) -> None:
        if self.finished.done() or not self._clock_owner.is_established:
            return
        age = (self._simulator.nanoseconds - self._voltage_stamp) * 1e-9
        fresh = self._voltage_stamp >= 0 and age <= self._settings.command_timeout
        self._stale_steps += not fresh
        self._advance(self._voltage if fresh else 0.0)
        if self._control_step % self._clock_steps == 0:
            self._outputs.publish_clock(self._simulator.nanoseconds)
        if self._simulator.sample >= self._end:
            self.finished.set_result(None)
            return
        self._publish_measurement(memory=self._settings.command_timeout)

    # Diagnostics ---------------------------------------------------------------------------

    def _health(self) -> Health:
        drive = self._drive
        troubles = self._stale_steps + self._resent + drive.limited_steps
        texts = []
        if drive.is_stopped:
            texts.append(self._drive.stop_reason)
        if troubles > self._reported_troubles:
            texts.append("commands missing, late or beyond the voltage limit")
        self._reported_troubles = troubles
        values = {
            "mode": self._settings.mode,
            "simulated_time_s": self._simulator.time,
            "control_steps": self._control_step,
            "steps_without_fresh_command": self._stale_steps,
            "resent_measurements": self._resent,
            "resent_batches": self._outputs.repeated_batches,
            "limited_steps": drive.limited_steps,
            "stopped_steps": drive.stopped_steps,
            "saturated_steps": self._simulator.saturated_steps,
            "dropped_samples": self._simulator.dropped_samples,
        }
        health = Health(not texts, "; ".join(texts) or "running", values, is_error=drive.is_stopped)
        return self._admission.complete(health)


def _awaited(nodes: list[str]) -> str:
    return "progress of " + ", ".join(nodes) if nodes else f"a {COMMAND.name}"


def main(args: list[str] | None = None) -> None:
    """Run the plant node; the console script ``plant_node``."""
    sys.exit(run_node(PlantNode, args))


if __name__ == "__main__":
    main()
