"""The part of a recording that a calibration looks at, and what makes it unusable."""

import numpy as np
from numpy.typing import NDArray

from bdt_analysis.re_estimation.estimator_setup import sampling_rate
from bdt_bags.reading.recording import Recording
from bdt_msgs_py.command_errors import BadInputError
from bdt_study.calibration.fitted_data import SETTINGS, Data
from bdt_twin.even_samples import EvenSamples, split_at_holes
from bdt_twin.stretch import LEAD, Stretch
from bdt_twin.telemetry_window import TelemetryWindow

FloatArray = NDArray[np.float64]

SHORTEST = 10.0
"""Telemetry that a calibration needs at least [s]."""
ENOUGH_MOTION = 0.98
"""Share of the most motion in any part of the recording that makes a later part the better one."""
SMALLEST_TURN = 1.0
"""Angle of the screw over which the platform has to move at least [rad]."""


def calibration_data(recording: Recording, seconds: float, pitch: float) -> Data:
    """Return the telemetry that is fitted: the latest part that moves as much as any other.

    Parameters
    ----------
    recording : Recording
        The run.
    seconds : float
        Longest time that is looked at [s].
    pitch : float
        Pitch of the lead screw [m/rad].

    Raises
    ------
    BadInputError
        If there is too little telemetry, or nothing moves in it.
    """
    rows, rate = recording.telemetry, sampling_rate(recording)
    label = f"bag {recording.path}"
    begin = _latest_motion(rows, rate, seconds)
    rows = rows[(rows[:, 0] >= begin) & (rows[:, 0] < begin + seconds)]
    window, even = TelemetryWindow(rate, round((seconds + 1.0) * rate)), EvenSamples(rate)
    for part in split_at_holes(rows, rate):
        samples = even.take(part)
        if len(samples):
            window.append(samples)
    data = Data([], rate)
    end = window.end or 0
    stretches = window.stretches(end, round(SETTINGS.shortest_stretch * rate), data.block)
    length = sum(stretch.voltage.size for stretch in stretches) / rate
    if length < SHORTEST:
        raise BadInputError(
            f"{label}: {length:.3g} s of telemetry without holes: must be at least {SHORTEST:g} s"
        )
    data = Data(stretches, rate)
    _check_motion(label, data, pitch)
    return data


def halves(data: Data) -> tuple[Data, Data]:
    """Return the first and the second half of data, cut at a multiple of a block."""
    samples = sum(stretch.voltage.size for stretch in data.stretches)
    left = samples // 2 // data.block * data.block
    first: list[Stretch] = []
    second: list[Stretch] = []
    for stretch in data.stretches:
        cut = min(left, stretch.voltage.size)
        left -= cut
        if cut:
            kept = stretch.voltage[:cut], stretch.position[:cut], stretch.before
            first.append(Stretch(stretch.first, *kept))
        if cut < stretch.voltage.size:
            begin = stretch.first + cut
            before = np.concatenate([stretch.before, stretch.voltage[:cut]])
            before = before[max(before.size - round(LEAD * data.sampling_rate), 0) :]
            second.append(Stretch(begin, stretch.voltage[cut:], stretch.position[cut:], before))
    return Data(first, data.sampling_rate), Data(second, data.sampling_rate)


def _latest_motion(rows: FloatArray, rate: float, seconds: float) -> float:
    """Return where the latest part begins that moves as much as any other [s]."""
    times, latest = rows[:, 0], rows[-1, 0] - seconds + 1.0 / rate
    if latest <= times[0]:
        return float(times[0])
    effort = np.concatenate([[0.0], np.cumsum(np.abs(rows[:, 1]))])
    begins = np.arange(times[0], latest, 1.0)
    begins = np.append(begins, latest) - 0.5 / rate
    first, last = np.searchsorted(times, begins), np.searchsorted(times, begins + seconds)
    moved = effort[last] - effort[first]
    return float(begins[np.flatnonzero(moved >= ENOUGH_MOTION * moved.max())[-1]])


def _check_motion(label: str, data: Data, pitch: float) -> None:
    if not any(np.ptp(stretch.voltage) > 0.0 for stretch in data.stretches):
        voltage = data.stretches[0].voltage[0]
        raise BadInputError(f"{label}: the motor does not move: its voltage is {voltage:g} V")
    # Means, because noise alone has a range, too.
    means = [stretch.position.reshape(-1, data.block).mean(axis=1) for stretch in data.stretches]
    motion = max(float(np.ptp(mean)) for mean in means)
    smallest = SMALLEST_TURN * pitch
    if motion < smallest:
        raise BadInputError(
            f"{label}: the platform moves over {1e6 * motion:.3g} um: must be at least "
            f"{1e6 * smallest:.3g} um, a radian of the screw"
        )
