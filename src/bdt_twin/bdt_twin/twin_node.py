"""Digital twin as a ROS 2 node: telemetry in, gap estimate out, dead zone reconfigured."""

import math
import sys
import time
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock, ClockType, JumpThreshold, TimeJump
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState, TimeReference
from std_msgs.msg import Float64MultiArray

from bdt_msgs_py.admission import Admission
from bdt_msgs_py.diagnostics import DiagnosticsPublisher, Health
from bdt_msgs_py.message_checks import check_telemetry_times, check_telemetry_values
from bdt_msgs_py.node_main import run_node
from bdt_msgs_py.node_parameters import (
    ConfigurationError,
    accepted,
    declare_all,
    destroy_on_error,
    reconfigured,
    rejected,
)
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_seconds
from bdt_msgs_py.rejection import MessageRejectedError, Reason
from bdt_msgs_py.telemetry_sequence import Admitted, TelemetrySequence
from bdt_msgs_py.topics import BACKLASH_ESTIMATE, PROGRESS, PROGRESS_PERIOD, TELEMETRY, TWIN_NODE
from bdt_msgs_py.writing import gap_estimate, progress
from bdt_plant.plant import PlantModel
from bdt_twin.dead_zone_delivery import DeadZoneDelivery
from bdt_twin.dead_zone_tolerance import DeadZoneRule
from bdt_twin.decider import create_decider
from bdt_twin.estimation_thread import EstimationThread
from bdt_twin.estimator import Estimate, estimate_values
from bdt_twin.estimator_choice import create_estimator
from bdt_twin.link import DelayedLink
from bdt_twin.parameters import PARAMETERS
from bdt_twin.reconfiguration import Reconfigurator
from bdt_twin.simulated_decision import (
    ControllerGains,
    Decision,
    decision_values,
    taken_back_because,
)

OF_THE_CONTROLLER = ("pid.", "notch.", "redesign.")
BOUNDED = "the gap is too uncertain: dead_zone.largest_growth bounds the dead zone"


class TwinNode(Node):
    """Estimates the gap from telemetry and sets the controller's dead zone over a slow link.

    Nothing here waits inside a callback: the estimator works in a thread of its own, a
    reconfiguration that is on its way is a timer on simulated time, one that is being answered is
    a future with a timeout on the wall clock.

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
        super().__init__(TWIN_NODE, **node_arguments)
        self._settings, link, dead_zone, self._choice, *others = declare_all(self, PARAMETERS)
        inverse_filter, output_error, motor, screw, structure, deciding, *gains = others
        model = PlantModel(motor, screw, structure)
        self._sampling_rate: float = inverse_filter.sampling_rate
        with destroy_on_error(self):
            try:
                settings = self._choice, model, inverse_filter, output_error
                self._estimator = estimator = create_estimator(*settings)
            except ValueError as error:
                raise ConfigurationError(f"parameter {error}") from error
        self._link = DelayedLink(link)
        self._reconfigurator = Reconfigurator(
            DeadZoneRule(dead_zone, model.lead_screw.pitch), self._link
        )
        self._received = self._telemetry_end = self._batch_samples = 0
        self._estimate: Estimate | None = None
        self._decision: Decision | None = None
        self._window_time = 0.0
        self._accepted = self._estimates = self._reported_troubles = 0
        self._estimator_errors, self._estimator_error = 0, ""
        self._sequence = TelemetrySequence(1.0 / self._sampling_rate)

        self._admission = Admission(self, (BACKLASH_ESTIMATE, TELEMETRY))
        self._delivery = DeadZoneDelivery(
            self,
            self._settings,
            self._reconfigurator,
            self._publish_progress,
            self._admission.reject,
        )
        self._estimate_publisher = self.create_publisher(
            JointState, BACKLASH_ESTIMATE.name, qos_profile(BACKLASH_ESTIMATE)
        )
        self._progress_publisher = self.create_publisher(
            TimeReference, PROGRESS.name, qos_profile(PROGRESS)
        )
        estimated = self.create_guard_condition(self._take_outcomes)
        today, redesign = ControllerGains(*gains[:2]), ControllerGains(*gains[2:])
        delay, horizon = self._link.expected_delay, dead_zone.horizon
        decider = create_decider(deciding, model, today, redesign, estimator, delay, horizon)
        self._estimation = EstimationThread(estimator, estimated.trigger, decider)
        self.create_subscription(
            Float64MultiArray, TELEMETRY.name, self._take_telemetry, qos_profile(TELEMETRY)
        )
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(PROGRESS_PERIOD, self._publish_progress, clock=steady)
        went_back = JumpThreshold(min_forward=None, min_backward=Duration(nanoseconds=-1))
        self._jumps = self.get_clock().create_jump_callback(
            went_back, post_callback=self._expect_restart
        )
        self._diagnostics = DiagnosticsPublisher(self, self._health)
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._use_parameters)

    def destroy_node(self) -> None:
        """End the estimation and destroy the node."""
        # Missing when the parameters were refused.
        if estimation := getattr(self, "_estimation", None):
            estimation.close()
        super().destroy_node()

    # Telemetry -----------------------------------------------------------------------------

    def _take_telemetry(self, message: Float64MultiArray) -> None:
        try:
            rows = check_telemetry_times(message)
            try:
                check_telemetry_values(rows)
                admitted = self._sequence.admit(rows, time.monotonic(), self._simulated_time())
            except MessageRejectedError:
                self._sequence.note_unusable(rows)
                raise
        except MessageRejectedError as error:
            self._admission.reject(TELEMETRY, error)
            return
        self._estimate_from(admitted)

    def _estimate_from(self, admitted: Admitted) -> None:
        """Hand admitted batches over to the estimator."""
        if admitted.stray is not None:
            self._admission.reject(TELEMETRY, admitted.stray)
        if admitted.hole is not None:
            self._estimation.put_hole(admitted.hole)
        for number, rows in enumerate(admitted.batches):
            self._received = nanoseconds_from_seconds(rows[-1, 0])
            self._admission.note_time(self._received)
            self._estimation.put(rows, begins=admitted.begins and number == 0)

    def _simulated_time(self) -> float | None:
        """Return the simulated time [s] by the clock; None without one."""
        is_simulated = self.get_parameter("use_sim_time").value
        return self.get_clock().now().nanoseconds * 1e-9 if is_simulated else None

    def _expect_restart(self, _jump: TimeJump) -> None:
        self._estimate_from(self._sequence.expect_restart())

    def _take_outcomes(self) -> None:
        """Use what the estimation found since the last time."""
        for outcome in self._estimation.outcomes():
            if outcome.fault and not outcome.is_hole:
                self._admission.reject(
                    TELEMETRY, MessageRejectedError(Reason.SAMPLES, outcome.fault)
                )
            self._accepted += not outcome.fault
            if outcome.error:
                self._estimator_errors += 1
                self._estimator_error = outcome.error
                self._warn(f"the estimator failed: {outcome.error}")
            if outcome.begins:
                self._delivery.restart()
                self._estimate = self._decision = None
            if math.isfinite(outcome.newest):
                self._telemetry_end = nanoseconds_from_seconds(outcome.newest)
                self._batch_samples = outcome.samples
            if outcome.estimate is not None:
                self._window_time = outcome.seconds
                self._use(outcome.estimate, outcome.decision)
            self._publish_progress()

    def _use(self, estimate: Estimate, decision: Decision | None) -> None:
        self._estimates += 1
        has_news = decision is not None and decision != self._decision
        if reason := taken_back_because(self._decision, decision):
            self._warn(reason)
        self._estimate, self._decision = estimate, decision
        tolerance = offset = None
        if self._settings.reconfigure:
            was_bounded = self._reconfigurator.is_bounded
            offset = estimate.compensation if self._settings.compensate_offset else None
            tolerance = self._reconfigurator.send(estimate, self._telemetry_end, offset, decision)
            if self._reconfigurator.is_bounded and not was_bounded:
                self.get_logger().warning(BOUNDED)
        if estimate.is_known:
            self._estimate_publisher.publish(
                gap_estimate(
                    nanoseconds_from_seconds(estimate.time),
                    estimate.gap,
                    estimate.uncertainty,
                    estimate.growth,
                    estimate.age,
                    tolerance,
                    offset,
                )
            )
        if has_news:
            # Bags shall hold each decision, however fast simulated time goes.
            self._diagnostics.publish()
        if self._settings.reconfigure:
            self._delivery.deliver()

    # Reconfiguration -----------------------------------------------------------------------

    def _check_parameters(self, changes: list[Parameter]) -> SetParametersResult:
        read_once = [each.name for each in changes if each.name.startswith(OF_THE_CONTROLLER)]
        if read_once:
            return rejected(f"{read_once[0]} is read when the twin starts")
        try:
            reconfigured(self._settings, "", changes)
        except ValueError as error:
            return rejected(str(error))
        return accepted()

    def _use_parameters(self, changes: list[Parameter]) -> None:
        self._settings = reconfigured(self._settings, "", changes)
        self._delivery.use(self._settings)
        self._publish_progress()

    def _publish_progress(self) -> None:
        times = (self._delivery.next_due(), self._next_action())
        promises = [time for time in times if time is not None]
        earliest_action = min(promises, default=None)
        self._progress_publisher.publish(
            progress(self.get_name(), self._telemetry_end, earliest_action)
        )

    def _next_action(self) -> int | None:
        """Return the earliest time [ns] at which telemetry yet to come can make the twin act.

        The next batch is as long as the last one, and it is published one sample after its
        newest sample.
        """
        if not (self._settings.reconfigure and self._batch_samples):
            return None
        batch = round(self._batch_samples * 1e9 / self._sampling_rate)
        published = self._telemetry_end + batch + round(1e9 / self._sampling_rate)
        return max(self._reconfigurator.earliest_action(self._telemetry_end, batch), published)

    # Diagnostics ---------------------------------------------------------------------------

    def _warn(self, text: str) -> None:
        self.get_logger().warning(text, throttle_duration_sec=1.0)

    def _health(self) -> Health:
        troubles = self._delivery.requests.failed + self._estimator_errors
        failed = troubles > self._reported_troubles
        texts = ["estimator or reconfiguration failed"] if failed else []
        self._reported_troubles = troubles
        is_bounded = self._settings.reconfigure and self._reconfigurator.is_bounded
        if is_bounded:
            texts.append(BOUNDED)
        values = {
            "estimator": self._choice.kind,
            "estimates": self._estimates,
            **estimate_values(self._estimate),
            **decision_values(self._decision),
            "estimator_errors": self._estimator_errors,
            "estimator_error": self._estimator_error,
            "telemetry_accepted": self._accepted,
            "telemetry_sampling": str(self._estimator.sampling),
            "telemetry_lag_s": (self._received - self._telemetry_end) * 1e-9,
            "window_time_s": self._window_time,
            "reconfigure": self._settings.reconfigure,
            "compensate_offset": self._settings.compensate_offset,
            "dead_zone_in_force_m": self._delivery.in_force.tolerance,
            "dead_zone_set_by": self._delivery.in_force.set_by,
            "dead_zone_at_bound": is_bounded,
            "reconfigurations": self._delivery.requests.accepted,
            "failed_reconfigurations": self._delivery.requests.failed,
            "refused_voltage_offsets": self._delivery.requests.refused_offsets,
            "lost_reconfigurations": self._link.lost,
            "overtaken_reconfigurations": self._link.overtaken,
        }
        health = Health(not texts, "; ".join(texts) or "estimating", values)
        return self._admission.complete(health)


def main(args: list[str] | None = None) -> None:
    """Run the twin node; the console script ``twin_node``."""
    sys.exit(run_node(TwinNode, args))


if __name__ == "__main__":
    main()
