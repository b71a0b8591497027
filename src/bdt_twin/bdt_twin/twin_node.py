"""Digital twin as a ROS 2 node: telemetry in, gap estimate out, dead zone reconfigured."""

import math
import sys
from typing import Any

import numpy as np
from rcl_interfaces.srv import SetParameters
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.task import Future
from rclpy.timer import Timer
from sensor_msgs.msg import JointState, TimeReference
from std_msgs.msg import Float64MultiArray

from bdt_msgs_py.diagnostics import DiagnosticsPublisher, Health
from bdt_msgs_py.node_main import run_node
from bdt_msgs_py.node_parameters import ConfigurationError, declare_all, gone_if_refused
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_seconds, read_samples
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    DEAD_ZONE_PARAMETER,
    PROGRESS,
    PROGRESS_PERIOD,
    TELEMETRY,
    TELEMETRY_COLUMNS,
    TWIN_NODE,
)
from bdt_msgs_py.writing import gap_estimate, progress
from bdt_plant.plant import PlantModel
from bdt_twin.dead_zone_width import DeadZoneRule
from bdt_twin.estimation_thread import EstimationThread
from bdt_twin.estimator import Estimate
from bdt_twin.estimator_choice import create_estimator
from bdt_twin.link import DelayedLink, Reconfiguration
from bdt_twin.parameters import PARAMETERS
from bdt_twin.reconfiguration import Reconfigurator


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
        self._settings, link, dead_zone, self._choice, *estimators, motor, screw, structure = (
            declare_all(self, PARAMETERS)
        )
        model = PlantModel(motor, screw, structure)
        inverse_filter, output_error = estimators
        self._sampling_rate: float = inverse_filter.sampling_rate
        with gone_if_refused(self):
            try:
                estimator = create_estimator(self._choice, model, inverse_filter, output_error)
            except ValueError as error:
                raise ConfigurationError(f"parameter {error}") from error
        self._link = DelayedLink(link)
        self._reconfigurator = Reconfigurator(
            DeadZoneRule(dead_zone, model.lead_screw.pitch), self._link
        )
        self._received = self._telemetry_end = self._batch_samples = 0
        self._estimate: Estimate | None = None
        self._window_time = 0.0
        self._accepted = self._rejected = self._estimates = 0
        self._reconfigurations = self._failures = self._reported_troubles = 0

        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._arrival_timer: Timer | None = None
        self._answer_timer: Timer | None = None
        self._in_flight: Reconfiguration | None = None
        self._answer: Future[SetParameters.Response] | None = None
        self._controller = AsyncParameterClient(self, self._settings.controller_node)
        self._estimate_publisher = self.create_publisher(
            JointState, BACKLASH_ESTIMATE.name, qos_profile(BACKLASH_ESTIMATE)
        )
        self._progress_publisher = self.create_publisher(
            TimeReference, PROGRESS.name, qos_profile(PROGRESS)
        )
        estimated = self.create_guard_condition(self._take_outcomes)
        self._estimation = EstimationThread(estimator, estimated.trigger)
        self.create_subscription(
            Float64MultiArray, TELEMETRY.name, self._take_telemetry, qos_profile(TELEMETRY)
        )
        self.create_timer(PROGRESS_PERIOD, self._tell_progress, clock=self._steady)
        self._diagnostics = DiagnosticsPublisher(self, self._health)

    def destroy_node(self) -> None:
        """End the estimation and destroy the node."""
        # Missing when the parameters were refused.
        if estimation := getattr(self, "_estimation", None):
            estimation.close()
        super().destroy_node()

    # Telemetry -----------------------------------------------------------------------------

    def _take_telemetry(self, message: Float64MultiArray) -> None:
        try:
            rows = read_samples(message, TELEMETRY_COLUMNS)
        except ValueError as error:
            self._reject(str(error))
            return
        if not len(rows):
            self._reject("the batch is empty")
            return
        if np.isfinite(rows[-1, 0]):
            self._received = nanoseconds_from_seconds(rows[-1, 0])
        self._estimation.put(rows)

    def _reject(self, reason: str) -> None:
        self._rejected += 1
        self._warn(f"rejected telemetry: {reason}")

    def _take_outcomes(self) -> None:
        """Use what the estimation found since the last time."""
        for outcome in self._estimation.outcomes():
            if outcome.fault:
                self._reject(outcome.fault)
            else:
                self._accepted += 1
            if outcome.begins:
                self._reconfigurator.restart()
                self._estimate = None
            self._window_time = outcome.seconds
            if math.isfinite(outcome.newest):
                self._telemetry_end = nanoseconds_from_seconds(outcome.newest)
                self._batch_samples = outcome.samples
            if outcome.estimate is not None:
                self._use(outcome.estimate)
            self._tell_progress()

    def _use(self, estimate: Estimate) -> None:
        self._estimates += 1
        self._estimate = estimate
        tolerance = None
        if self._settings.reconfigure:
            tolerance = self._reconfigurator.send(estimate, self._telemetry_end)
        if estimate.is_known:
            self._estimate_publisher.publish(
                gap_estimate(
                    nanoseconds_from_seconds(estimate.time),
                    estimate.gap,
                    estimate.uncertainty,
                    estimate.growth,
                    estimate.age,
                    tolerance,
                )
            )
        if self._settings.reconfigure:
            self._deliver()

    # Reconfiguration -----------------------------------------------------------------------

    def _deliver(self) -> None:
        """Ask the controller for what has arrived; come back for what is still on its way."""
        if self._in_flight is not None:
            return
        now = self.get_clock().now().nanoseconds
        self._in_flight = self._reconfigurator.deliver(now)
        if self._in_flight is not None:
            value = self._in_flight.tolerance
            request = Parameter(DEAD_ZONE_PARAMETER, Parameter.Type.DOUBLE, value)
            self._answer = self._controller.set_parameters([request])
            self._answer.add_done_callback(self._take_answer)
            self._answer_timer = self.create_timer(
                self._settings.service_timeout, self._give_up, clock=self._steady
            )
            return
        self._arrival_timer = self._destroyed(self._arrival_timer)
        due = self._reconfigurator.next_due()
        if due is not None:
            self._arrival_timer = self.create_timer((due - now) * 1e-9, self._deliver)

    def _take_answer(self, answer: "Future[SetParameters.Response]") -> None:
        if answer is not self._answer or answer.cancelled():
            return
        response = answer.result()
        if response is None:
            return  # not an answer: the timeout will count it
        (result,) = response.results
        if result.successful:
            self._reconfigurations += 1
        else:
            self._failures += 1
            self._warn(f"the controller refused the dead zone: {result.reason}")
        self._request_ended()

    def _give_up(self) -> None:
        self._failures += 1
        self._warn(f"no answer from {self._settings.controller_node} to a reconfiguration")
        if self._answer is not None:
            self._answer.cancel()
        self._request_ended()

    def _request_ended(self) -> None:
        self._answer = self._in_flight = None
        self._answer_timer = self._destroyed(self._answer_timer)
        self._deliver()
        self._tell_progress()

    def _destroyed(self, timer: Timer | None) -> Timer | None:
        """Destroy a timer, if there is one, and return the None that takes its place."""
        if timer is not None:
            self.destroy_timer(timer)
        return None

    def _tell_progress(self) -> None:
        known = (
            self._in_flight.due if self._in_flight is not None else self._reconfigurator.next_due()
        )
        promises = [time for time in (known, self._next_action()) if time is not None]
        acts_at = min(promises, default=None)
        self._progress_publisher.publish(progress(self.get_name(), self._telemetry_end, acts_at))

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
        troubles = self._rejected + self._failures
        well = troubles == self._reported_troubles
        self._reported_troubles = troubles
        values = {
            "estimator": self._choice.kind,
            "estimates": self._estimates,
            **_described(self._estimate),
            "telemetry_accepted": self._accepted,
            "telemetry_rejected": self._rejected,
            "telemetry_lag_s": (self._received - self._telemetry_end) * 1e-9,
            "window_time_s": self._window_time,
            "reconfigurations": self._reconfigurations,
            "failed_reconfigurations": self._failures,
            "lost_reconfigurations": self._link.lost,
            "overtaken_reconfigurations": self._link.overtaken,
        }
        return Health(well, "estimating" if well else "telemetry or reconfiguration failed", values)


def _described(estimate: Estimate | None) -> dict[str, float | int | str | None]:
    """Return what the diagnostics say of an estimate."""
    if estimate is None:
        return {"gap_estimate_rad": None}
    return {
        "gap_estimate_rad": estimate.gap,
        "gap_uncertainty_rad": estimate.uncertainty,
        "gap_growth_rad_per_s": estimate.growth,
        "gain_correction": estimate.gain_correction,
        "reversals": estimate.reversals,
        "nothing_learned_because": estimate.reason,
    }


def main(args: list[str] | None = None) -> None:
    """Run the twin node; the console script ``twin_node``."""
    sys.exit(run_node(TwinNode, args))


if __name__ == "__main__":
    main()
