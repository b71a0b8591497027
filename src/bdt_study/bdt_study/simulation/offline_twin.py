"""The digital twin without nodes: telemetry in, what arrives at the controller out."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from bdt_controller.notch import NotchFilter
from bdt_controller.pid import PidGains
from bdt_msgs_py.parameter_tables import parameter_sets
from bdt_msgs_py.reading import nanoseconds_from_seconds
from bdt_twin.decider import Decider
from bdt_twin.decision import ControllerGains, Decision
from bdt_twin.estimator import Estimate, Estimator
from bdt_twin.reconfiguration import Reconfigurator

FloatArray = NDArray[np.float64]


class OfflineTwin:
    """Estimator, link and dead zone, as the twin's node puts them together.

    Parameters
    ----------
    estimator : Estimator
        What estimates the gap.
    reconfigurator : Reconfigurator
        Dead zone for an estimate, and the link to the controller.
    decider : Decider
        What decides by simulation.
    compensates : bool
        Whether the controller is to be set against an offset of the amplifier.

    Attributes
    ----------
    estimates : list of Estimate
        What the estimator has said.
    decisions : list of Decision
        What has been decided by simulation.
    """

    def __init__(
        self,
        estimator: Estimator,
        reconfigurator: Reconfigurator,
        decider: Decider,
        compensates: bool,
    ) -> None:
        self._estimator = estimator
        self._reconfigurator = reconfigurator
        self._decider = decider
        self._compensates = compensates
        self._tolerance: float | None = None
        self._offset: float | None = None
        self.estimates: list[Estimate] = []
        self.decisions: list[Decision] = []

    def reconfigure(
        self, stamps: NDArray[np.int64], tolerances: FloatArray, offsets: FloatArray
    ) -> dict[int, ControllerGains]:
        """Set what is in force at the next measurements.

        Parameters
        ----------
        stamps : ndarray, shape (n,)
            Times of the measurements [ns].
        tolerances : ndarray, shape (n,)
            Tolerances without the twin [m]; overwritten from the first reconfiguration on.
        offsets : ndarray, shape (n,)
            Voltage offsets without the twin [V]; overwritten from the first one that it sets.

        Returns
        -------
        dict
            Gains to be set, by the place of the measurement from which on they count.
        """
        switches: dict[int, ControllerGains] = {}
        if self._tolerance is not None:
            tolerances[:] = self._tolerance
        if self._offset is not None:
            offsets[:] = self._offset
        while (due := self._reconfigurator.next_due()) is not None and due <= stamps[-1]:
            first = int(np.searchsorted(stamps, due))
            arrived = self._reconfigurator.deliver(int(stamps[first]))
            if arrived is not None:
                self._tolerance = arrived.tolerance
                tolerances[first:] = self._tolerance
            if arrived is not None and arrived.voltage_offset is not None:
                self._offset = arrived.voltage_offset
                offsets[first:] = self._offset
            if arrived is not None and arrived.gains:
                switches[first] = _gains_of(dict(arrived.gains))
        return switches

    def take_telemetry(self, rows: FloatArray) -> None:
        """Estimate from the rows (t [s], u [V], q3 [m]) of a batch, and send (eq. 9)."""
        estimate = self._estimator.update(rows)
        decision = self._decider(rows, estimate, begins=False)
        if decision is not None:
            self.decisions.append(decision)
        if estimate is not None:
            self.estimates.append(estimate)
            offset = estimate.compensation if self._compensates else None
            end = nanoseconds_from_seconds(rows[-1, 0])
            self._reconfigurator.send(estimate, end, offset, decision)


def _gains_of(values: Mapping[str, float]) -> ControllerGains:
    """Return gains by the names of the controller's parameters."""
    pid, notch = parameter_sets((("pid", PidGains), ("notch", NotchFilter)), values)
    return ControllerGains(pid, notch)
