"""Dead-zone PID controller as a ROS 2 node: answers every measurement with a command."""

import secrets
import sys
import time
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import JumpThreshold, TimeJump
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState

from bdt_controller.controller import DeadZoneController
from bdt_controller.parameters import PARAMETERS
from bdt_controller.plausibility import PlausibilityCheck, UnbelievedReadingError, Verdict
from bdt_controller.reference import reference_at
from bdt_controller.stand_by import StandBy
from bdt_msgs_py.admission import Admission
from bdt_msgs_py.clock_check import USE_SIM_TIME
from bdt_msgs_py.diagnostics import DiagnosticsPublisher, Health
from bdt_msgs_py.message_checks import check_position
from bdt_msgs_py.node_main import run_node
from bdt_msgs_py.node_parameters import (
    accepted,
    declare_all,
    reconfigured,
    rejected,
)
from bdt_msgs_py.qos import publisher_profile, qos_profile
from bdt_msgs_py.real_time import RealTimeProcess
from bdt_msgs_py.rejection import MessageRejectedError
from bdt_msgs_py.sole_publisher import publisher_count
from bdt_msgs_py.topics import (
    COMMAND,
    CONTROLLER_NODE,
    DEAD_ZONE_PARAMETER,
    MEASUREMENT,
    REFERENCE,
)
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
        (
            self._settings,
            self._gains,
            self._notch,
            self._reference,
            self._plausible,
            real_time,
        ) = declare_all(self, PARAMETERS)
        self._controller = DeadZoneController(self._gains, self._settings, self._notch)
        self._period = round(1e9 / self._settings.control_rate)
        self._missed = self._restarts = self._reported_troubles = 0
        self._dead_zone_set_by = "start-up"
        self._plausibility = PlausibilityCheck(self._plausible, self._settings.control_rate)
        self._source = ""
        self._stand_by = StandBy(self)
        self._reference_position: float | None = None
        self._reset()

        self._command_publisher = self.create_publisher(
            JointState, COMMAND.name, publisher_profile(COMMAND)
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
        self._admission = Admission(self, (COMMAND, REFERENCE, MEASUREMENT))
        went_back = JumpThreshold(min_forward=None, min_backward=Duration(nanoseconds=-1))
        self._jumps = self.get_clock().create_jump_callback(
            went_back, post_callback=self._expect_restart
        )
        self._diagnostics = DiagnosticsPublisher(self, self._health)
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._use_parameters)
        self._process = RealTimeProcess(real_time, self.get_logger().warning)

    def _reset(self) -> None:
        self._controller.reset()
        self._first_stamp: int | None = None
        self._last_stamp = -1
        self._voltage = self._controller.resting_voltage

    # Measurements --------------------------------------------------------------------------

    def _take_measurement(self, message: JointState) -> None:
        try:
            stamp, position = check_position(message)
        except MessageRejectedError as error:
            self._admission.reject(MEASUREMENT, error)
            return
        try:
            verdict: Verdict | None = self._plausibility.check(stamp, position, time.monotonic())
        except UnbelievedReadingError as error:
            self._admission.reject(MEASUREMENT, error)
            verdict = None
        except MessageRejectedError as error:
            self._admission.reject(MEASUREMENT, error)
            return
        if self._stand_by.look(stamp):
            return
        # Without a reading to believe the voltage in force goes on: a plant waits for an answer.
        if verdict is not None and (verdict is not Verdict.REPEAT or self._last_stamp < 0):
            self._advance(stamp, position, begins=verdict is Verdict.BEGIN)
        self._command_publisher.publish(motor_voltage(stamp, self._voltage, self._source))
        self._process.use_slack()

    def _advance(self, stamp: int, position: float, *, begins: bool) -> None:
        if begins and self._last_stamp >= 0:
            self._restarts += 1
            self.get_logger().warning("time went back: the controller starts anew")
            self._reset()
        self._source = self._source or self._command_source()
        self._count_missed(stamp)
        self._admission.note_time(stamp)
        self._last_stamp = stamp
        self._voltage = self._next_voltage(stamp, position)

    def _next_voltage(self, stamp: int, position: float) -> float:
        """Return the voltage that answers a measurement: rest while there is no reference."""
        if self._reference.kind != "topic":
            self._follow_reference(stamp)
        if self._reference_position is None:
            return self._controller.resting_voltage
        return self._controller.step(self._reference_position, position)

    def _command_source(self) -> str:
        """Return what commands name as their source.

        It is the name of the node, the same in every run. Where commands are already published,
        perhaps by a node of the same name, the plant has to tell this one apart.
        """
        name = self.get_fully_qualified_name()
        alone = publisher_count(self, COMMAND) <= 1
        return name if alone else f"{name} {secrets.token_hex(4)}"

    def _expect_restart(self, _jump: TimeJump) -> None:
        self._plausibility.expect_restart()

    def _count_missed(self, stamp: int) -> None:
        if self._last_stamp >= 0:
            self._missed += max(round((stamp - self._last_stamp) / self._period) - 1, 0)

    # Reference -----------------------------------------------------------------------------

    def _follow_reference(self, stamp: int) -> None:
        """Take the reference from the parameters.

        In simulated time it begins with time, so that a controller that comes later, or anew, goes
        on with it. Wall time has no beginning: there the first measurement starts it.
        """
        begins = self._first_stamp is None
        if self._first_stamp is None:
            self._first_stamp = 0 if self.get_parameter(USE_SIM_TIME).value else stamp
        reference_position = reference_at(self._reference, (stamp - self._first_stamp) * 1e-9)
        if begins or reference_position != self._reference_position:
            self._reference_position = reference_position
            self._reference_publisher.publish(platform_position(stamp, reference_position))

    def _take_reference(self, message: JointState) -> None:
        try:
            stamp, position = check_position(message)
            self._plausible.check_reference(position, stamp, self._last_stamp)
        except MessageRejectedError as error:
            self._admission.reject(REFERENCE, error)
            return
        self._reference_position = position

    # Parameters ----------------------------------------------------------------------------

    def _check_parameters(self, changes: list[Parameter]) -> SetParametersResult:
        try:
            reconfigured(self._gains, "pid", changes)
            reconfigured(self._notch, "notch", changes)
            reconfigured(self._settings, "", changes)
            reconfigured(self._reference, "reference", changes)
        except ValueError as error:
            return rejected(str(error))
        return accepted()

    def _use_parameters(self, changes: list[Parameter]) -> None:
        self._gains = reconfigured(self._gains, "pid", changes)
        self._notch = reconfigured(self._notch, "notch", changes)
        self._settings = reconfigured(self._settings, "", changes)
        self._reference = reconfigured(self._reference, "reference", changes)
        if any(change.name == DEAD_ZONE_PARAMETER for change in changes):
            self._dead_zone_set_by = "parameter service"
        self._controller.configure(self._gains, self._settings, self._notch)

    # Diagnostics ---------------------------------------------------------------------------

    def _health(self) -> Health:
        troubles = self._missed + self._restarts
        texts = list(self._process.refusals)
        if troubles > self._reported_troubles:
            texts.append("measurements missing or begun anew")
        if self._stand_by.is_on:
            texts.append("another controller answers: standing by")
        self._reported_troubles = troubles
        values = {
            "dead_zone_tolerance_m": self._settings.dead_zone_tolerance,
            "dead_zone_set_by": self._dead_zone_set_by,
            "voltage_offset_v": self._settings.voltage_offset,
            "reference_m": self._reference_position,
            "reference_began_s": None if self._first_stamp is None else self._first_stamp * 1e-9,
            "missed_measurements": self._missed,
            "restarts": self._restarts,
        }
        health = Health(not texts, "; ".join(texts) or "controlling", values)
        return self._admission.complete(health)


def main(args: list[str] | None = None) -> None:
    """Run the controller node; the console script ``controller_node``."""
    sys.exit(run_node(ControllerNode, args))


if __name__ == "__main__":
    main()
