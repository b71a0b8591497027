"""Telemetry on its way from the topic to the estimation: checked, put in sequence, handed over."""

import time

from rclpy.clock import JumpThreshold, TimeJump
from rclpy.duration import Duration
from rclpy.node import Node
from std_msgs.msg import Float64MultiArray

from bdt_msgs_py.admission import Admission
from bdt_msgs_py.message_checks import check_telemetry_times, check_telemetry_values
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_seconds
from bdt_msgs_py.rejection import MessageRejectedError
from bdt_msgs_py.telemetry_sequence import Admitted, TelemetrySequence
from bdt_msgs_py.topics import TELEMETRY
from bdt_twin.estimation_thread import EstimationThread


class TelemetryIntake:
    """Subscription of the telemetry.

    Parameters
    ----------
    node : rclpy.node.Node
        The twin.
    admission : Admission
        Told of what is rejected, and of times.
    estimation : EstimationThread
        Gets what is admitted.
    sampling_rate : float
        Rate of the samples [Hz].

    Attributes
    ----------
    newest : int
        Stamp of the newest sample that was admitted [ns].
    """

    def __init__(
        self, node: Node, admission: Admission, estimation: EstimationThread, sampling_rate: float
    ) -> None:
        self._node, self._admission, self._estimation = node, admission, estimation
        self._sequence = TelemetrySequence(1.0 / sampling_rate)
        self.newest = 0
        node.create_subscription(
            Float64MultiArray, TELEMETRY.name, self._take_telemetry, qos_profile(TELEMETRY)
        )
        went_back = JumpThreshold(min_forward=None, min_backward=Duration(nanoseconds=-1))
        self._jumps = node.get_clock().create_jump_callback(
            went_back, post_callback=self._expect_restart
        )

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
        self._hand_over(admitted)

    def _hand_over(self, admitted: Admitted) -> None:
        if admitted.stray is not None:
            self._admission.reject(TELEMETRY, admitted.stray)
        if admitted.hole is not None:
            self._estimation.put_hole(admitted.hole)
        for number, rows in enumerate(admitted.batches):
            self.newest = nanoseconds_from_seconds(rows[-1, 0])
            self._admission.note_time(self.newest)
            self._estimation.put(rows, begins=admitted.begins and number == 0)

    def _simulated_time(self) -> float | None:
        """Return the simulated time [s] by the clock; None without one."""
        is_simulated = self._node.get_parameter("use_sim_time").value
        return self._node.get_clock().now().nanoseconds * 1e-9 if is_simulated else None

    def _expect_restart(self, _jump: TimeJump) -> None:
        self._hand_over(self._sequence.expect_restart())
