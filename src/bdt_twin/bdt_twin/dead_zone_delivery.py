"""The last part of a reconfiguration's way, from the end of the slow link to the controller."""

from collections.abc import Callable, Mapping, Sequence

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from bdt_msgs_py.rejection import MessageRejectedError
from bdt_msgs_py.topics import (
    DEAD_ZONE_PARAMETER,
    PROGRESS_PERIOD,
    VOLTAGE_OFFSET_PARAMETER,
    Topic,
)
from bdt_twin.controller_account import BY_SERVICE, Account, ControllerAccount
from bdt_twin.dead_zone_requests import DeadZoneRequests
from bdt_twin.dead_zone_watch import DeadZoneWatch
from bdt_twin.link import Reconfiguration
from bdt_twin.reconfiguration import Reconfigurator
from bdt_twin.twin_settings import TwinSettings
from bdt_twin.twin_state import TwinState


class DeadZoneDelivery:
    """Asks the controller for what has arrived, and a controller that comes anew once more.

    A twin that comes later than its controller goes on from what the controller has, as soon as
    that says that it is not what it began with.

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
    gain_names : sequence of str
        The controller's parameters that the twin sets beside dead zone and offset.

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
        gain_names: Sequence[str] = (),
    ) -> None:
        self._node, self._reconfigurator = node, reconfigurator
        self._progressed = progressed
        self._settings = settings
        # Made once: rclpy never forgets quite all of a timer that was destroyed.
        self._arrival = node.create_timer(1.0, self.deliver, autostart=False)
        self._gain_names, self._is_own, self._has_adopted = gain_names, False, False
        controller, timeout = settings.controller_node, settings.service_timeout
        self.requests = DeadZoneRequests(node, controller, timeout, self._request_ended)
        self._watch = DeadZoneWatch(
            node, controller, self._set_by_somebody_else, self._look_for_controller, reject
        )
        self.in_force = self._watch.state
        names = (DEAD_ZONE_PARAMETER, VOLTAGE_OFFSET_PARAMETER, *gain_names)
        self._account = ControllerAccount(
            node, controller, timeout, names, self._is_in_doubt, self._take_account
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
        self._is_own = self._has_adopted = False
        self._reconfigurator.restart()
        self.requests.drop()
        self._arrival.cancel()

    def close(self) -> None:
        """Take no answer any more: the node is about to go."""
        self.requests.close()
        self._account.close()

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
            self._is_own = True
            self._watch.request(arrived)
            self.requests.send(arrived)
            return
        self._arrival.cancel()
        due = self._reconfigurator.next_due()
        if due is not None:
            self._arrival.timer_period_ns = due - now
            self._arrival.reset()

    def resume(self, kept: TwinState) -> None:
        """Go on from what was in force when a twin ended; a controller of then has it still."""
        if self._settings.reconfigure:
            self.requests.note_informed(kept.lives)
            self._resume(kept.tolerance, kept.voltage_offset, kept.gains)

    def _resume(
        self, tolerance: float, offset: float | None, gains: tuple[tuple[str, float], ...]
    ) -> None:
        offset = offset if self._settings.compensate_offset else None
        gains = tuple((name, value) for name, value in gains if name in self._gain_names)
        now = self._node.get_clock().now().nanoseconds
        self._reconfigurator.resume(now, tolerance, offset, gains)

    def _is_in_doubt(self, set_by: str) -> bool:
        """Tell whether a controller may have something else than the twin believes."""
        if not self._settings.reconfigure or self.next_due() is not None:
            return False
        return (
            not self._is_own if set_by == BY_SERVICE else self._reconfigurator.in_force is not None
        )

    def _take_account(self, account: Account) -> None:
        if not self._is_in_doubt(account.set_by):
            return
        values, in_force = account.values, self._reconfigurator.in_force
        if account.set_by == BY_SERVICE:
            self._adopt(values)
        elif in_force is not None and _differ(values, in_force):
            self._send_again("the controller has what it began with")

    def _adopt(self, values: Mapping[str, float]) -> None:
        tolerance = values[DEAD_ZONE_PARAMETER]
        gains = tuple((name, values[name]) for name in self._gain_names if name in values)
        self._resume(tolerance, values.get(VOLTAGE_OFFSET_PARAMETER), gains)
        self.requests.note_informed()
        self._progressed()
        if not self._has_adopted:
            self._has_adopted = True
            self.in_force.adopt(tolerance)
            self._node.get_logger().info(
                f"the controller's dead zone of {tolerance:g} m stays until the gap is known"
            )

    def next_due(self) -> int | None:
        """Return when the next reconfiguration arrives or has arrived [ns]; None without one."""
        in_flight = self.requests.in_flight
        return in_flight.due if in_flight is not None else self._reconfigurator.next_due()

    def _request_ended(self, unanswered: Reconfiguration | None) -> None:
        if unanswered is None:
            # The next question puts in doubt again what this answer has told.
            self._progressed()
        self.deliver(unanswered)
        self._progressed()

    def _look_for_controller(self) -> None:
        """Send what is in force to a controller that has just come, and knows nothing of it."""
        if self.requests.controller_appeared() and self._settings.reconfigure:
            self._send_again("a new controller")

    def _send_again(self, reason: str) -> None:
        if self._reconfigurator.send_again(self._node.get_clock().now().nanoseconds):
            self._node.get_logger().info(f"{reason}: the dead zone in force is sent again")
            self.deliver()
            self._progressed()

    def _set_by_somebody_else(self, text: str) -> None:
        if self._settings.reconfigure:
            self._node.get_logger().warning(
                f"{text}: the next estimate sets it again while reconfigure is true",
                throttle_duration_sec=1.0,
            )


def _differ(values: Mapping[str, float], in_force: Reconfiguration) -> bool:
    """Tell whether a controller has anything else than what is in force, as far as it has it."""
    wanted = {DEAD_ZONE_PARAMETER: in_force.tolerance, **dict(in_force.gains)}
    if in_force.voltage_offset is not None:
        wanted[VOLTAGE_OFFSET_PARAMETER] = in_force.voltage_offset
    return any(values.get(name, value) != value for name, value in wanted.items())
