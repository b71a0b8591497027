"""Digital twin as a ROS 2 node: telemetry in, gap estimate out, dead zone reconfigured."""

import sys
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState, TimeReference

from bdt_msgs_py.admission import Admission
from bdt_msgs_py.diagnostics import DiagnosticsPublisher, Health
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
from bdt_msgs_py.topics import BACKLASH_ESTIMATE, PROGRESS, PROGRESS_PERIOD, TELEMETRY, TWIN_NODE
from bdt_msgs_py.writing import gap_estimate, progress
from bdt_plant.plant import PlantModel
from bdt_twin.dead_zone_delivery import DeadZoneDelivery
from bdt_twin.dead_zone_tolerance import DeadZoneRule
from bdt_twin.dead_zone_watch import full_name
from bdt_twin.decider import create_decider
from bdt_twin.decision import ControllerGains, Decision, taken_back_because
from bdt_twin.estimation_record import EstimationRecord
from bdt_twin.estimation_thread import EstimationThread
from bdt_twin.estimator import Estimate
from bdt_twin.estimator_choice import create_estimator
from bdt_twin.gains_check import GainsCheck
from bdt_twin.kept_state import KeptState
from bdt_twin.link import DelayedLink
from bdt_twin.parameters import PARAMETERS
from bdt_twin.reconfiguration import Reconfigurator
from bdt_twin.telemetry_intake import TelemetryIntake

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
        self._settings, self._link_settings, dead_zone, self._choice, *others = declare_all(
            self, PARAMETERS
        )
        inverse_filter, output_error, motor, screw, structure, deciding, *gains = others
        model = PlantModel(motor, screw, structure)
        self._sampling_rate: float = inverse_filter.sampling_rate
        controller = full_name(self, self._settings.controller_node)
        with destroy_on_error(self):
            try:
                settings = self._choice, model, inverse_filter, output_error
                self._estimator = estimator = create_estimator(*settings)
                self._kept = KeptState(
                    self._settings, controller, self._choice.kind, model, self.get_logger()
                )
            except ValueError as error:
                raise ConfigurationError(f"parameter {error}") from error
        self._link = DelayedLink(self._link_settings)
        self._reconfigurator = Reconfigurator(
            DeadZoneRule(dead_zone, model.lead_screw.pitch), self._link
        )
        self._record, self._reported_troubles = EstimationRecord(), 0

        self._admission = Admission(self, (BACKLASH_ESTIMATE, TELEMETRY))
        today, redesign = ControllerGains(*gains[:2]), ControllerGains(*gains[2:])
        self._delivery = DeadZoneDelivery(
            self,
            self._settings,
            self._reconfigurator,
            self._note_progress,
            self._admission.reject,
            tuple(dict(redesign.by_name())) if deciding.sets_gains else (),
        )
        if self._kept.recalled is not None:
            self._delivery.resume(self._kept.recalled.state)
            self._kept.recall_machine(estimator)
        self._estimate_publisher = self.create_publisher(
            JointState, BACKLASH_ESTIMATE.name, qos_profile(BACKLASH_ESTIMATE)
        )
        self._progress_publisher = self.create_publisher(
            TimeReference, PROGRESS.name, qos_profile(PROGRESS)
        )
        estimated = self.create_guard_condition(self._take_outcomes)
        decider = create_decider(
            deciding,
            model,
            today,
            redesign,
            estimator,
            self._link.expected_delay,
            dead_zone.horizon,
            self._reconfigurator.gains_in_force,
        )
        self._estimation = EstimationThread(estimator, estimated.trigger, decider)
        self._intake = TelemetryIntake(self, self._admission, self._estimation, self._sampling_rate)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(PROGRESS_PERIOD, self._publish_progress, clock=steady)
        self._gains_check: GainsCheck | None = None
        if deciding.kind == "simulate":
            known = (today, redesign) if deciding.sets_gains else (today,)
            self._gains_check = GainsCheck(
                self, self._settings.controller_node, self._settings.service_timeout, known
            )
        self._diagnostics = DiagnosticsPublisher(self, self._health)
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._use_parameters)

    def destroy_node(self) -> None:
        """End the estimation and destroy the node."""
        # Missing when the parameters were refused.
        if estimation := getattr(self, "_estimation", None):
            estimation.close()
        if kept := getattr(self, "_kept", None):
            kept.close()
        # The executor may have an answer that nobody can take any more.
        for asking in ("_delivery", "_gains_check"):
            if asked := getattr(self, asking, None):
                asked.close()
        super().destroy_node()

    # Estimates -----------------------------------------------------------------------------

    def _take_outcomes(self) -> None:
        """Use what the estimation found since the last time."""
        for outcome in self._estimation.outcomes():
            if outcome.fault and not outcome.is_hole:
                self._admission.reject(
                    TELEMETRY, MessageRejectedError(Reason.SAMPLES, outcome.fault)
                )
            self._record.take(outcome)
            if outcome.error:
                self._warn(f"the estimator failed: {outcome.error}")
            if outcome.begins:
                self._delivery.restart()
            if outcome.estimate is not None:
                self._use(outcome.estimate, outcome.decision)
            self._publish_progress()

    def _use(self, estimate: Estimate, decision: Decision | None) -> None:
        before = self._record.decision
        has_news = decision is not None and decision != before
        if reason := taken_back_because(before, decision):
            self._warn(reason)
        self._record.use(estimate, decision)
        tolerance = offset = None
        if self._settings.reconfigure:
            was_bounded = self._reconfigurator.is_bounded
            offset = estimate.compensation if self._settings.compensate_offset else None
            tolerance = self._reconfigurator.send(
                estimate, self._record.telemetry_end, offset, decision
            )
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
        self._keep_state()

    # Reconfiguration -----------------------------------------------------------------------

    def _check_parameters(self, changes: list[Parameter]) -> SetParametersResult:
        try:
            reconfigured(self._settings, "", changes)
            reconfigured(self._link_settings, "", changes)
        except ValueError as error:
            return rejected(str(error))
        return accepted()

    def _use_parameters(self, changes: list[Parameter]) -> None:
        self._settings = reconfigured(self._settings, "", changes)
        self._delivery.use(self._settings)
        link = reconfigured(self._link_settings, "", changes)
        if link != self._link_settings:
            self._link_settings = link
            self._link.use(link)
        self._publish_progress()

    def _note_progress(self) -> None:
        """Keep and tell what has become of a reconfiguration."""
        self._keep_state()
        self._publish_progress()

    def _keep_state(self) -> None:
        # Until there is an answer nobody knows what is in force.
        if self._delivery.requests.in_flight is not None:
            return
        self._kept.note(
            self._reconfigurator.in_force,
            self._delivery.requests.informed,
            self._record,
        )

    def _publish_progress(self) -> None:
        times = (self._delivery.next_due(), self._next_action())
        promises = [time for time in times if time is not None]
        earliest_action = min(promises, default=None)
        self._progress_publisher.publish(
            progress(self.get_name(), self._record.telemetry_end, earliest_action)
        )

    def _next_action(self) -> int | None:
        """Return the earliest time [ns] at which telemetry yet to come can make the twin act.

        The next batch is as long as the last one, and it is published one sample after its
        newest sample.
        """
        end, samples = self._record.telemetry_end, self._record.batch_samples
        if not (self._settings.reconfigure and samples):
            return None
        batch = round(samples * 1e9 / self._sampling_rate)
        published = end + batch + round(1e9 / self._sampling_rate)
        return max(self._reconfigurator.earliest_action(end, batch), published)

    # Diagnostics ---------------------------------------------------------------------------

    def _warn(self, text: str) -> None:
        self.get_logger().warning(text, throttle_duration_sec=1.0)

    def _health(self) -> Health:
        troubles = self._delivery.requests.failed + self._record.errors
        failed = troubles > self._reported_troubles
        texts = ["estimator or reconfiguration failed"] if failed else []
        self._reported_troubles = troubles
        if fault := self._kept.fault():
            texts.append(fault)
        is_bounded = self._settings.reconfigure and self._reconfigurator.is_bounded
        if is_bounded:
            texts.append(BOUNDED)
        if (decision := self._record.decision) is not None and decision.distrust:
            texts.append(decision.reason)
        if self._gains_check is not None and self._gains_check.fault:
            texts.append(self._gains_check.fault)
        values = {
            "estimator": self._choice.kind,
            "telemetry_sampling": str(self._estimator.sampling),
            **self._record.values(self._intake.newest),
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
            **self._kept.values(),
        }
        health = Health(not texts, "; ".join(texts) or "estimating", values)
        return self._admission.complete(health)


def main(args: list[str] | None = None) -> None:
    """Run the twin node; the console script ``twin_node``."""
    sys.exit(run_node(TwinNode, args))


if __name__ == "__main__":
    main()
