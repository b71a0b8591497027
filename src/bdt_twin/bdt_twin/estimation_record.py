"""What has come of the telemetry so far: the newest estimate and decision, and counts."""

import math

from bdt_msgs_py.reading import nanoseconds_from_seconds
from bdt_twin.decision import Decision, decision_values
from bdt_twin.estimation_thread import Outcome
from bdt_twin.estimator import Estimate, estimate_values
from bdt_twin.machine_recollection import MachineRecollection


class EstimationRecord:
    """Sums up outcomes of the estimation.

    Attributes
    ----------
    telemetry_end : int
        Stamp of the newest sample that was worked on [ns].
    batch_samples : int
        Number of samples in the newest batch.
    estimate : Estimate or None
        The newest estimate of this run.
    decision : Decision or None
        What was decided for it.
    machine : MachineRecollection or None
        What is worth keeping of the machine.
    estimates, errors : int
        Numbers of estimates, and of failures of somebody's estimator.
    """

    def __init__(self) -> None:
        self.telemetry_end = self.batch_samples = 0
        self.estimate: Estimate | None = None
        self.decision: Decision | None = None
        self.machine: MachineRecollection | None = None
        self.estimates = self.errors = 0
        self._accepted, self._window_time, self._error = 0, 0.0, ""

    def take(self, outcome: Outcome) -> None:
        """Take an outcome, without what was estimated and decided: see :meth:`use`."""
        self._accepted += not outcome.fault
        if outcome.error:
            self.errors += 1
            self._error = outcome.error
        if outcome.begins:
            self.estimate = self.decision = None
        if math.isfinite(outcome.newest):
            self.telemetry_end = nanoseconds_from_seconds(outcome.newest)
            self.batch_samples = outcome.samples
        self.machine = outcome.machine
        if outcome.estimate is not None:
            self._window_time = outcome.seconds

    def use(self, estimate: Estimate, decision: Decision | None) -> None:
        """Take an estimate, and what was decided for it."""
        self.estimates += 1
        self.estimate, self.decision = estimate, decision

    def values(self, received: int) -> dict[str, object]:
        """Return what the diagnostics say.

        Parameters
        ----------
        received : int
            Stamp of the newest sample that has come [ns].
        """
        return {
            "estimates": self.estimates,
            **estimate_values(self.estimate),
            **decision_values(self.decision),
            "estimator_errors": self.errors,
            "estimator_error": self._error,
            "telemetry_accepted": self._accepted,
            "telemetry_lag_s": (received - self.telemetry_end) * 1e-9,
            "window_time_s": self._window_time,
        }
