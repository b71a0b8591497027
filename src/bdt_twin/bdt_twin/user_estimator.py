"""Somebody's estimator: found by module and name, called as it wants, its errors told in a line."""

import math
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.user_code import UserCode, binds, wanted_of
from bdt_plant.plant import PlantModel
from bdt_twin.estimator import Estimate, TelemetryRejectedError

MAY_BE_NAN = ("gap", "uncertainty")
"""Numbers of an estimate that may be unknown."""

NOT_NEGATIVE = ("uncertainty", "growth_uncertainty", "age", "voltage_offset_uncertainty")

MAY_BE_INFINITE = ("uncertainty", "voltage_offset_uncertainty")


class UserEstimatorError(BadInputError):
    """Somebody's estimator cannot be made or has failed: one line with its file and line."""


class UserEstimator:
    """An estimator from outside this package as one that the twin can rely on.

    Batches that are empty or not finite do not reach it. It is restarted before the first batch
    and when time goes back.

    Parameters
    ----------
    kind : str
        ``module:name`` of a class with ``restart()`` and ``update(batch)``, or of a function that
        returns such an object. The module may lie in the current folder. The class gets what it
        asks for of ``model`` and ``sampling_rate``, by these names or in this order. An `update`
        that has a parameter ``newest_only`` gets it as well.
    model : PlantModel
        Constants of the mechanism, as the twin knows them.
    sampling_rate : float
        Sampling rate of the telemetry [Hz].

    Raises
    ------
    UserEstimatorError
        If there is no such module or class, or if it fails.
    """

    def __init__(self, kind: str, model: PlantModel, sampling_rate: float) -> None:
        self._code = code = UserCode(kind, UserEstimatorError)
        with code.errors_in_one_line():
            given = wanted_of(code.factory, {"model": model, "sampling_rate": sampling_rate})
            if given is None:
                code.fail(code.factory, "must take no arguments, or model and sampling_rate")
            estimator = given()
        self._restart = code.method(estimator, "restart", takes="")
        batch = np.empty((0, 3))
        update = getattr(estimator, "update", None)
        self._takes_newest_only = callable(update) and binds(update, batch, newest_only=False)
        options = {"newest_only": False} if self._takes_newest_only else {}
        self._update = code.method(estimator, "update", batch, takes="one batch", **options)
        self._last_time = -math.inf
        self.restart()

    def restart(self) -> None:
        """Forget everything; see :class:`bdt_twin.estimator.Estimator`."""
        with self._code.errors_in_one_line():
            self._restart()

    def update(self, batch: NDArray[np.float64], *, newest_only: bool = False) -> Estimate | None:
        """Take the next batch; see :class:`bdt_twin.estimator.Estimator`.

        Raises
        ------
        TelemetryRejectedError
            For a batch that is empty or not finite, and if the estimator raises it.
        UserEstimatorError
            For any other error of the estimator, and if it returns no estimate.
        """
        if not batch.size:
            raise TelemetryRejectedError("the batch is empty")
        if not np.isfinite(batch).all():
            raise TelemetryRejectedError("the batch is not finite")
        if batch[0, 0] < self._last_time:
            self.restart()
        self._last_time = float(batch[-1, 0])
        options = {"newest_only": newest_only} if self._takes_newest_only else {}
        with self._code.errors_in_one_line(TelemetryRejectedError):
            found = self._update(batch, **options)
        return None if found is None else self._checked(found)

    def _checked(self, found: Any) -> Estimate:
        if not isinstance(found, Estimate):
            self._code.fail(self._update, f"update returned {found!r}: must be an Estimate or None")
        for name, value in found._asdict().items():
            if fault := _fault_of(name, value):
                self._code.fail(
                    self._update, f"update returned {name} = {value!r}: must be {fault}"
                )
        reason = found.reason
        if math.isnan(found.gap) and not reason:
            reason = (
                f"{self._code.place_of(self._update)}: {self._code.name}: the gap is not a number"
            )
        return found._replace(reason=reason)


def _fault_of(name: str, value: Any) -> str:
    """Return what a field of an estimate must be; empty if it is that."""
    if name == "reason":
        return "" if isinstance(value, str) else "a text"
    if not isinstance(value, Real):
        return "a number"
    number = float(value)
    if name in NOT_NEGATIVE and number < 0.0:
        return "at least 0"
    if math.isfinite(number) or (name in MAY_BE_NAN and math.isnan(number)):
        return ""
    return "" if name in MAY_BE_INFINITE and not math.isnan(number) else "finite"
