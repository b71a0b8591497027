"""Digital twin as a ROS 2 node: telemetry in, gap estimate out, dead zone reconfigured."""

import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray
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
from bdt_twin.dead_zone_width import tolerance_for_gap
from bdt_twin.estimator import TelemetryRejectedError
from bdt_twin.inverse_filter import InverseFilterEstimator
from bdt_twin.link import DelayedLink, Reconfiguration
from bdt_twin.parameters import PARAMETERS
from bdt_twin.telemetry_stream import TelemetryStream


class TwinNode(Node):
    """Estimates the gap from telemetry and sets the controller's dead zone over a slow link.

    Nothing here waits inside a callback: a reconfiguration that is on its way is a timer on
    simulated time, one that is being answered is a future with a timeout on the wall clock.

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
        self._settings, settings, *model = declare_all(self, PARAMETERS)
        self._model = PlantModel(*model)
        self._sampling_rate = settings.sampling_rate
        self._stream = TelemetryStream(settings.sampling_rate)
        with gone_if_refused(self):
            try:
                self._estimator = InverseFilterEstimator(self._model, settings)
            except ValueError as error:
                raise ConfigurationError(f"parameter {error}") from error
        self._link = DelayedLink(self._settings.communication_delay)
        self._stream_start = 0
        self._telemetry_end: int = 0
        self._batch_samples = 0
        self._gap: float | None = None
        self._malformed = self._estimates = self._reconfigurations = self._failures = 0
        self._reported_troubles = 0

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
        self.create_subscription(
            Float64MultiArray, TELEMETRY.name, self._take_telemetry, qos_profile(TELEMETRY)
        )
        self.create_timer(PROGRESS_PERIOD, self._tell_progress, clock=self._steady)
        self._diagnostics = DiagnosticsPublisher(self, self._health)

    # Telemetry -----------------------------------------------------------------------------

    def _take_telemetry(self, message: Float64MultiArray) -> None:
        try:
            rows = read_samples(message, TELEMETRY_COLUMNS)
        except ValueError as error:
            self._malformed += 1
            self._warn(f"rejected telemetry: {error}")
            return
        try:
            if self._stream.accept(rows):
                self._begin_stream(rows)
            self._use(rows)
        except TelemetryRejectedError as error:
            self._warn(f"rejected telemetry: {error}; the estimator restarts with the next batch")
        if len(rows) and np.isfinite(rows[-1, 0]):
            self._telemetry_end = nanoseconds_from_seconds(rows[-1, 0])
            self._batch_samples = len(rows)
        self._tell_progress()

    def _begin_stream(self, rows: NDArray[np.float64]) -> None:
        self._estimator.restart()
        self._link.drop()
        self._stream_start = nanoseconds_from_seconds(rows[0, 0])
        if self._stream.restarts:
            self.get_logger().warning(f"the estimator restarted at t = {rows[0, 0]:.3f} s")

    def _use(self, rows: NDArray[np.float64]) -> None:
        estimates = self._estimator.update(rows[:, 1], rows[:, 2])
        for estimate in estimates:
            stamp = self._stream_start + round(estimate.sample * 1e9 / self._sampling_rate)
            self._estimate_publisher.publish(gap_estimate(stamp, estimate.gap))
        self._estimates += len(estimates)
        if estimates:
            self._gap = estimates[-1].gap
            if self._settings.reconfigure:
                tolerance = tolerance_for_gap(self._gap, self._model.lead_screw.pitch)
                self._link.send(nanoseconds_from_seconds(rows[-1, 0]), stamp, tolerance)
                self._deliver()

    # Reconfiguration -----------------------------------------------------------------------

    def _deliver(self) -> None:
        """Ask the controller for what has arrived; come back for what is still on its way."""
        if self._in_flight is not None:
            return
        now = self.get_clock().now().nanoseconds
        self._in_flight = self._link.deliver(now)
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
        due = self._link.next_due()
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
        known = self._in_flight.due if self._in_flight is not None else self._link.next_due()
        promises = [time for time in (known, self._next_action()) if time is not None]
        acts_at = min(promises, default=None)
        self._progress_publisher.publish(progress(self.get_name(), self._telemetry_end, acts_at))

    def _next_action(self) -> int | None:
        """Return the earliest time [ns] at which telemetry yet to come can make the twin act.

        The next batch is as long as the last one. It is published one sample after its newest
        sample, and what is learned from it arrives after the delay of the link.
        """
        if not (self._settings.reconfigure and self._batch_samples):
            return None
        sample_time = 1e9 / self._sampling_rate
        end: int = self._telemetry_end + round(self._batch_samples * sample_time)
        later: int = max(round(self._settings.communication_delay * 1e9), round(sample_time))
        return end + later

    # Diagnostics ---------------------------------------------------------------------------

    def _warn(self, text: str) -> None:
        self.get_logger().warning(text, throttle_duration_sec=1.0)

    def _health(self) -> Health:
        troubles = self._malformed + self._stream.rejected + self._failures
        well = troubles == self._reported_troubles
        self._reported_troubles = troubles
        values = {
            "gap_estimate_rad": self._gap,
            "estimates": self._estimates,
            "telemetry_accepted": self._stream.accepted,
            "telemetry_rejected": self._stream.rejected + self._malformed,
            "estimator_restarts": self._stream.restarts,
            "reconfigurations": self._reconfigurations,
            "failed_reconfigurations": self._failures,
        }
        return Health(well, "estimating" if well else "telemetry or reconfiguration failed", values)


def main(args: list[str] | None = None) -> None:
    """Run the twin node; the console script ``twin_node``."""
    sys.exit(run_node(TwinNode, args))


if __name__ == "__main__":
    main()
