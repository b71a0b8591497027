"""Driver as a ROS 2 node: measurement and telemetry of a real drive out, commands in."""

import sys
import time
from functools import partial
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger

from bdt_driver.drive_loop import DriveLoop, NumberedReading, State
from bdt_driver.guarded_drive import DriveError, GuardedDrive
from bdt_driver.parameters import PARAMETERS
from bdt_driver.telemetry_rows import SampledByHardware, SampledWhenRead, TelemetryRows
from bdt_msgs_py.admission import Admission
from bdt_msgs_py.awaited_commands import AwaitedCommands
from bdt_msgs_py.clock_check import keep_wall_time
from bdt_msgs_py.diagnostics import DiagnosticsPublisher, Health
from bdt_msgs_py.message_checks import check_command
from bdt_msgs_py.node_main import run_node
from bdt_msgs_py.node_parameters import ConfigurationError, declare_all, declare_options
from bdt_msgs_py.qos import publisher_profile, qos_profile
from bdt_msgs_py.real_time import RealTimeProcess
from bdt_msgs_py.rejection import MessageRejectedError
from bdt_msgs_py.topics import COMMAND, DRIVER_NODE, MEASUREMENT, TELEMETRY, TELEMETRY_COLUMNS
from bdt_msgs_py.writing import platform_position, sample_message


class DriverNode(Node):
    """Owns the timing of a drive: reads it at the control rate, obeys commands when armed.

    Measurements are published while the drive is armed: a controller that nobody obeys would wind
    up. Telemetry is published whenever the drive is open.

    Parameters
    ----------
    **node_arguments
        Passed on to :class:`rclpy.node.Node`, for example ``context`` or ``parameter_overrides``.

    Raises
    ------
    ConfigurationError
        For a parameter that is unknown or not allowed, and for a drive that cannot be made or
        does not open.
    """

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__(DRIVER_NODE, **node_arguments)
        options = declare_options(self, "drive")
        self._settings, limits, real_time = declare_all(self, PARAMETERS)
        self._measurement = self.create_publisher(
            JointState, MEASUREMENT.name, publisher_profile(MEASUREMENT)
        )
        self._telemetry = self.create_publisher(
            Float64MultiArray, TELEMETRY.name, qos_profile(TELEMETRY)
        )
        self._diagnostics = DiagnosticsPublisher(self, self._health)
        self._admission = Admission(self, (MEASUREMENT, TELEMETRY, COMMAND))
        keep_wall_time(self, "a drive lives in wall time")
        self._commands = AwaitedCommands(self._settings.command_timeout)
        self._late_call = ""
        if not self._settings.driver:
            raise self._refusal("must be module:name of your drive's class")
        try:
            self._drive = GuardedDrive(
                self._settings.driver,
                options,
                self._settings.command_timeout,
                self._tell_late,
                brings_samples=self._settings.sampling_rate > 0.0,
            )
        except DriveError as error:
            raise self._refusal(str(error)) from error
        self._loop = DriveLoop(self._drive, self._settings, limits)
        self._reported_fault = ""
        self._first_stamp: int | None = None
        rate = self._settings.telemetry_rate
        self._rows = TelemetryRows()
        self._sampling = (
            SampledByHardware(self._rows, rate)
            if self._settings.sampling_rate
            else SampledWhenRead(self._rows)
        )
        self._batch = max(round(self._settings.telemetry_period * rate), 1)
        self._reported_troubles = 0
        self.create_subscription(JointState, COMMAND.name, self._take_command, qos_profile(COMMAND))
        self.create_service(Trigger, "~/arm", partial(self._serve, self._loop.arm))
        self.create_service(Trigger, "~/disarm", partial(self._serve, self._loop.disarm))
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0 / self._settings.control_rate, self._tick, clock=steady)
        self._open()
        self._process = RealTimeProcess(real_time, self.get_logger().warning)

    def _open(self) -> None:
        try:
            self._loop.open(time.monotonic())
        except DriveError as error:
            self._drive.end()
            raise self._refusal(f"the drive does not open: {error}") from error

    def _refusal(self, text: str) -> ConfigurationError:
        self.destroy_node()
        return ConfigurationError(f"parameter driver = {self._settings.driver!r}: {text}")

    # Timing --------------------------------------------------------------------------------

    def _tick(self) -> None:
        read = self._loop.tick(time.monotonic())
        if read is not None:
            self._publish(read)
        self._tell_fault()
        if not self._loop.is_engaged:
            self._use_slack()  # else once the command has come

    def _publish(self, read: NumberedReading) -> None:
        self._publish_full_batch()  # of which no command has let it go
        if self._first_stamp is None:
            self._first_stamp = self.get_clock().now().nanoseconds - read.nanoseconds
        # Times since the first reading keep the last digits of a double.
        time_since = self._sampling.add(read.number, read.nanoseconds * 1e-9, read.reading)
        if time_since is not None and self._loop.state is State.ARMED:
            self._ask(self._first_stamp + round(time_since * 1e9), read.reading.position)

    def _publish_full_batch(self) -> None:
        if self._first_stamp is None or len(self._rows) < self._batch:
            return
        for batch in self._rows.take():
            batch[:, 0] += self._first_stamp * 1e-9
            self._telemetry.publish(sample_message(batch, TELEMETRY_COLUMNS))

    def _ask(self, stamp: int, position: float) -> None:
        """Publish a measurement, and await its answer until it is too old."""
        memory = round(self._settings.command_timeout * 1e9)
        self._commands.published(stamp, stamp - memory, time.monotonic())
        self._measurement.publish(platform_position(stamp, position))

    def _take_command(self, message: JointState) -> None:
        try:
            command = check_command(message)
            is_new = self._commands.accept(command, time.monotonic())
        except MessageRejectedError as error:
            self._admission.reject(COMMAND, error)
            return
        if is_new:
            self._loop.command(command.voltage, time.monotonic())
            self._tell_fault()
            self._use_slack()

    def _use_slack(self) -> None:
        """Do what the answer to a measurement must not wait for."""
        self._publish_full_batch()
        self._process.use_slack()

    # States --------------------------------------------------------------------------------

    def _serve(
        self, transition: Any, _request: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        before = self._loop.state
        response.message = transition(time.monotonic()) or self._loop.state.value
        response.success = response.message == self._loop.state.value
        if self._loop.state is not before:
            self.get_logger().info(f"the drive is {self._loop.state.value}")
        self._tell_fault()
        self._diagnostics.publish()
        return response

    def _tell_fault(self) -> None:
        fault = self._loop.fault
        if fault and fault != self._reported_fault:
            self.get_logger().error(f"the drive is stopped: {fault}")
            self._diagnostics.publish()
        self._reported_fault = fault

    def _tell_late(self, line: str) -> None:
        """Tell of a call that does not return; called in a thread of its own."""
        self._late_call = line
        self.get_logger().error(f"the drive hangs: {line}")
        self._diagnostics.publish()

    def destroy_node(self) -> None:
        """Stop and close the drive, then end the node."""
        loop = getattr(self, "_loop", None)
        if loop is not None and loop.state is not State.CLOSED:
            try:
                loop.close()
            except DriveError as error:
                self.get_logger().error(f"the drive does not end: {error}")
            self._drive.end()
        super().destroy_node()

    # Diagnostics ---------------------------------------------------------------------------

    def _health(self) -> Health:
        loop = self._loop
        texts = [loop.fault or self._late_call] if loop.fault or self._late_call else []
        texts += self._process.refusals
        if loop.state is State.ARMED and not loop.is_engaged:
            texts.append("armed, and no commands come")
        troubles = loop.missed + loop.silences + loop.unreadable + loop.limited
        if troubles > self._reported_troubles:
            texts.append("readings or commands missing, or commands beyond a limit")
        self._reported_troubles, self._late_call = troubles, ""
        values = {
            "state": loop.state.value,
            "fault": loop.fault,
            "voltage_v": loop.voltage,
            "missed_periods": loop.missed,
            "hardware_clock_drift": self._sampling.drift,
            "unreadable_readings": loop.unreadable,
            "silences_of_commands": loop.silences,
            "limited_commands": loop.limited,
        }
        health = Health(
            not texts, "; ".join(texts) or loop.state.value, values, is_error=bool(loop.fault)
        )
        return self._admission.complete(health)


def main(args: list[str] | None = None) -> None:
    """Run the driver node; the console script ``driver_node``."""
    sys.exit(run_node(DriverNode, args))


if __name__ == "__main__":
    main()
