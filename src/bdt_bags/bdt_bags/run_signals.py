"""Signals of one run of the loop, whether recorded or simulated offline."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class RunSignals:
    """One run as arrays, all on the clock of the telemetry, less `time_origin`.

    Attributes
    ----------
    time_origin : float
        Zero for simulated time; the whole second at which the telemetry begins when its clock
        counts from 1970 [s].
    telemetry : ndarray, shape (n, 3)
        Rows of (t [s], u [V], q3 [m]), t strictly increasing.
    truth : ndarray, shape (m, 7), or None
        Rows of (t, theta_m, theta_d, gap, q1, q2, q3) [s, rad, m].
    reference : ndarray, shape (k, 2)
        Rows of (time from which it holds [s], r [m]).
    estimates : ndarray, shape (k, 2)
        Rows of (time for which the gap is stated [s], gap [rad]).
    dead_zones : ndarray, shape (k, 2)
        Rows of (time [s], dead-zone tolerance [m] from then on), the initial one included when
        it is known.
    pitch : float or None
        Pitch of the lead screw [m/rad]; None when the recording tells none.
    uncertainties : ndarray, shape (k, 2)
        Rows of (time [s], standard uncertainty of the estimate in force [rad]); empty when the
        twin tells none.
    requests : ndarray, shape (k, 4)
        Rows of (newest sample behind an estimate [s], dead-zone tolerance that the twin asks for
        because of it [m], time for which the estimate is stated [s], gap [rad]) in the order of
        the newest sample; empty when the twin tells none.
    voltage_offset_requests : ndarray, shape (k, 2)
        Rows of (newest sample behind an estimate [s], voltage that the twin asks the controller
        to add to its commands because of it [V]) in the order of the newest sample; empty when it
        asks for none.
    held_gaps : ndarray, shape (k, 2)
        Rows of (newest sample behind an estimate [s], gap [rad]) in the order of the newest
        sample: the twin holds this gap from then on until the next row; empty when every gap is
        stated for its newest sample.
    """

    time_origin: float = 0.0
    telemetry: FloatArray
    truth: FloatArray | None
    reference: FloatArray
    estimates: FloatArray
    dead_zones: FloatArray
    pitch: float | None
    uncertainties: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    requests: FloatArray = field(default_factory=lambda: np.empty((0, 4)))
    voltage_offset_requests: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    held_gaps: FloatArray = field(default_factory=lambda: np.empty((0, 2)))

    @property
    def sample_time(self) -> float:
        """Sample time of the telemetry [s]."""
        return float(np.median(np.diff(self.telemetry[:, 0])))

    @property
    def duration(self) -> float:
        """Time covered by the telemetry [s], the last sample's own sample time included."""
        return float(self.telemetry[-1, 0] - self.telemetry[0, 0]) + self.sample_time
