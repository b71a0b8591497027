"""Dead-zone PID controller as a ROS 2 node: answers every measurement with a command."""

import math
import sys
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState

from bdt_controller.controller import DeadZoneController
from bdt_controller.parameters import PARAMETERS
from bdt_controller.reference import reference_at
from bdt_msgs_py.diagnostics import DiagnosticsPublisher, Health
from bdt_msgs_py.node_main import run_node
from bdt_msgs_py.node_parameters import (
    accepted,
    declare_all,
    reconfigured,
    refused,
)
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import read_position
from bdt_msgs_py.topics import COMMAND, CONTROLLER_NODE, MEASUREMENT, PLATFORM_JOINT, REFERENCE
from bdt_msgs_py.writing import motor_voltage, platform_position


class ControllerNode(Node):
    """Controls the position of platform 3; dead zone and gains can be set while it runs.

    Parameters
    ----------
    **node_arguments
        Passed on to :class:`rclpy.node.Node`, for example ``context`` or ``parameter_overrides``.

    Raises
    ------
    ConfigurationError
        For a parameter that is unknown or not allowed.
    """

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__(CONTROLLER_NODE, **node_arguments)
        self._settings, self._gains, self._reference = declare_all(self, PARAMETERS)
        self._controller = DeadZoneController(self._gains, self._settings)
        self._period = round(1e9 / self._settings.control_rate)
        self._rejected = self._missed = self._restarts = self._reported_troubles = 0
        self._target: float | None = None
        self._forget_the_run()

        self._command_publisher = self.create_publisher(
            JointState, COMMAND.name, qos_profile(COMMAND)
        )
        if self._reference.kind == "topic":
            self.create_subscription(
                JointState, REFERENCE.name, self._take_reference, qos_profile(REFERENCE)
            )
        else:
            self._reference_publisher = self.create_publisher(
                JointState, REFERENCE.name, qos_profile(REFERENCE)
            )
        self.create_subscription(
            JointState, MEASUREMENT.name, self._take_measurement, qos_profile(MEASUREMENT)
        )
        self._diagnostics = DiagnosticsPublisher(self, self._health)
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._use_parameters)

    def _forget_the_run(self) -> None:
        self._controller.reset()
        self._first_stamp: int | None = None
        self._last_stamp = -1
        self._command: JointState | None = None

    # Measurements --------------------------------------------------------------------------

    def _take_measurement(self, message: JointState) -> None:
        try:
            stamp, position = read_position(message, PLATFORM_JOINT)
        except ValueError as error:
            self._reject(str(error))
            return
        if not math.isfinite(position):
            self._reject(f"position {position} m: must be finite")
            return
        if stamp == self._last_stamp and self._command is not None:
            self._command_publisher.publish(self._command)
            return
        if stamp < self._last_stamp:
            self._restarts += 1
            self.get_logger().warning("time went back: the controller starts anew")
            self._forget_the_run()
        self._count_missed(stamp)
        self._last_stamp = stamp
        self._command = motor_voltage(stamp, self._voltage(stamp, position))
        self._command_publisher.publish(self._command)

    def _voltage(self, stamp: int, position: float) -> float:
        """Return the voltage that answers a measurement; zero while there is no reference."""
        if self._reference.kind != "topic":
            self._follow_reference(stamp)
        if self._target is None:
            return 0.0
        return self._controller.step(self._target, position)

    def _count_missed(self, stamp: int) -> None:
        if self._last_stamp >= 0:
            self._missed += max(round((stamp - self._last_stamp) / self._period) - 1, 0)

    def _reject(self, reason: str) -> None:
        self._rejected += 1
        self.get_logger().warning(f"rejected a message: {reason}", throttle_duration_sec=1.0)

    # Reference -----------------------------------------------------------------------------

    def _follow_reference(self, stamp: int) -> None:
        """Take the reference from the parameters; the first measurement starts it."""
        begins = self._first_stamp is None
        if self._first_stamp is None:
            self._first_stamp = stamp
        target = reference_at(self._reference, (stamp - self._first_stamp) * 1e-9)
        if begins or target != self._target:
            self._target = target
            self._reference_publisher.publish(platform_position(stamp, target))

    def _take_reference(self, message: JointState) -> None:
        try:
            _, target = read_position(message, PLATFORM_JOINT)
        except ValueError as error:
            self._reject(str(error))
            return
        if not math.isfinite(target):
            self._reject(f"reference {target} m: must be finite")
            return
        self._target = target

    # Parameters ----------------------------------------------------------------------------

    def _check_parameters(self, changes: list[Parameter]) -> SetParametersResult:
        try:
            reconfigured(self._gains, "pid", changes)
            reconfigured(self._settings, "", changes)
        except ValueError as error:
            return refused(str(error))
        return accepted()

    def _use_parameters(self, changes: list[Parameter]) -> None:
        self._gains = reconfigured(self._gains, "pid", changes)
        self._settings = reconfigured(self._settings, "", changes)
        self._controller.configure(self._gains, self._settings)

    # Diagnostics ---------------------------------------------------------------------------

    def _health(self) -> Health:
        troubles = self._rejected + self._missed + self._restarts
        well = troubles == self._reported_troubles
        self._reported_troubles = troubles
        values = {
            "dead_zone_tolerance_m": self._settings.dead_zone_tolerance,
            "reference_m": self._target,
            "rejected_messages": self._rejected,
            "missed_measurements": self._missed,
            "restarts": self._restarts,
        }
        return Health(well, "controlling" if well else "measurements missing or not valid", values)


def main(args: list[str] | None = None) -> None:
    """Run the controller node; the console script ``controller_node``."""
    sys.exit(run_node(ControllerNode, args))


if __name__ == "__main__":
    main()
