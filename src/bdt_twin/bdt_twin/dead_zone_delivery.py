"""The last part of a reconfiguration's way, from the end of the slow link to the controller."""

from collections.abc import Callable

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.timer import Timer

from bdt_msgs_py.rejection import MessageRejectedError
from bdt_msgs_py.topics import PROGRESS_PERIOD, Topic
from bdt_twin.dead_zone_requests import DeadZoneRequests
from bdt_twin.dead_zone_watch import DeadZoneWatch
from bdt_twin.link import Reconfiguration
from bdt_twin.reconfiguration import Reconfigurator
from bdt_twin.twin_settings import TwinSettings


class DeadZoneDelivery:
    """Asks the controller for what has arrived, and a controller that comes anew once more.

    Nothing here waits inside a callback: what is on its way is a timer on simulated time.

    Parameters
    ----------
    node : rclpy.node.Node
        The twin.
    settings : TwinSettings
        Which controller, how long an answer may take, and whether to reconfigure at all.
    reconfigurator : Reconfigurator
        Where reconfigurations come from.
    progressed : callable
        Called when something has happened to a reconfiguration outside of the twin's own calls.
    reject : callable
        Called with topic and reason for a message that cannot be true.

    Attributes
    ----------
    requests : DeadZoneRequests
        What the controller was asked for.
    in_force : DeadZoneInForce
        What is known of the controller's dead zone.
    """

    def __init__(
        self,
        node: Node,
        settings: TwinSettings,
        reconfigurator: Reconfigurator,
        progressed: Callable[[], object],
        reject: Callable[[Topic, MessageRejectedError], object],
    ) -> None:
        self._node, self._reconfigurator = node, reconfigurator
        self._progressed = progressed
        self._settings = settings
        self._arrival_timer: Timer | None = None
        controller = settings.controller_node
        self.in_force = DeadZoneWatch(node, controller, self._set_by_somebody_else, reject).state
        self.requests = DeadZoneRequests(
            node, controller, settings.service_timeout, self._request_ended
        )
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        node.create_timer(PROGRESS_PERIOD, self._look_for_controller, clock=steady)

    def use(self, settings: TwinSettings) -> None:
        """Reconfigure from now on what the settings say, and leave the rest to somebody else."""
        self._settings = settings
        # Whoever has taken something over is not to be surprised by what is on its way.
        if not settings.reconfigure:
            self.restart()
        if not settings.compensate_offset:
            self.requests.forget_offset()

    def restart(self) -> None:
        """Forget what is on its way and what is in force."""
        self._reconfigurator.restart()
        self.requests.drop()
        self._destroy_arrival_timer()

    def deliver(self, unanswered: Reconfiguration | None = None) -> None:
        """Ask the controller for what has arrived; come back for what is still on its way.

        Parameters
        ----------
        unanswered : Reconfiguration or None
            What was asked for without an answer: asked for again, unless a newer one has arrived.
        """
        if self.requests.in_flight is not None:
            return
        now = self._node.get_clock().now().nanoseconds
        arrived = self._reconfigurator.deliver(now) or unanswered
        if arrived is not None:
            if not self._settings.compensate_offset:
                arrived = arrived._replace(voltage_offset=None)
            self.in_force.request(arrived.tolerance)
            self.requests.send(arrived)
            return
        self._destroy_arrival_timer()
        due = self._reconfigurator.next_due()
        if due is not None:
            self._arrival_timer = self._node.create_timer((due - now) * 1e-9, self.deliver)

    def next_due(self) -> int | None:
        """Return when the next reconfiguration arrives or has arrived [ns]; None without one."""
        in_flight = self.requests.in_flight
        return in_flight.due if in_flight is not None else self._reconfigurator.next_due()

    def _request_ended(self, unanswered: Reconfiguration | None) -> None:
        self.deliver(unanswered)
        self._progressed()

    def _look_for_controller(self) -> None:
        """Send what is in force to a controller that has just come, and knows nothing of it."""
        if not (self.requests.controller_appeared() and self._settings.reconfigure):
            return
        if self._reconfigurator.send_again(self._node.get_clock().now().nanoseconds):
            self._node.get_logger().info("a new controller: the dead zone in force is sent again")
            self.deliver()
            self._progressed()

    def _set_by_somebody_else(self, text: str) -> None:
        if self._settings.reconfigure:
            self._node.get_logger().warning(
                f"{text}: the next estimate sets it again while reconfigure is true",
                throttle_duration_sec=1.0,
            )

    def _destroy_arrival_timer(self) -> None:
        if self._arrival_timer is not None:
            self._node.destroy_timer(self._arrival_timer)
            self._arrival_timer = None
