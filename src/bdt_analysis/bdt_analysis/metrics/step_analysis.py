"""Each step of the reference in numbers: residual, bias, settling time, limit cycle."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bdt_analysis.metrics.oscillation import Oscillation, find_oscillation
from bdt_analysis.metrics.reference_steps import ReferenceStep

FloatArray = NDArray[np.float64]

SETTLING_BAND = 0.02
"""Distance from the final position, as a part of the height, within which a step has settled."""

LIMIT_CYCLE_THRESHOLD = 0.01
"""Peak to peak of an oscillation, as a part of the height, above which it is a limit cycle."""

CLEAN = 0.9
"""Part of the peak to peak that an oscillation without noise and drift has after smoothing."""

SHORTEST_JUDGED = 1.0
"""Length [s] of the window below which neither settling nor a limit cycle can be told."""

LOOKED_AT_ONCE = 8192
"""Samples whose distances from the final position are looked at together."""


@dataclass(frozen=True)
class StepSummary:
    """One step; the fields of ``steps`` in ``summary.json``.

    Attributes
    ----------
    t_start_s : float
        Beginning of the step [s].
    reference_m : float
        Reference r [m].
    residual_peak_to_peak_m : float or None
        Peak to peak of q3 over the last 3 s [m].
    bias_m : float or None
        Mean of q3 over the last 3 s minus r [m].
    bias_percent_of_amplitude : float or None
        The bias, with its sign, as percent of the height of the step.
    settling_time_s : float or None
        Time from the beginning of the step after which q3 stays within 2 % of the height around
        its mean over the last 3 s. None when it still leaves that band in the last third of
        those 3 s: then nothing shows that it will stay.
    limit_cycle : bool or None
        True when q3 oscillates in the last 3 s with more than 1 % of the height peak to peak and
        does not decay; see :func:`bdt_analysis.metrics.oscillation.find_oscillation`.
    limit_cycle_amplitude_m : float or None
        Half of the peak to peak of that oscillation [m]; None without a limit cycle.
    limit_cycle_frequency_hz : float or None
        Its frequency [Hz]; None without a limit cycle.

    Notes
    -----
    For steps shorter than 6 s, the last half takes the place of the last 3 s. None stands where a
    value is unknown: everywhere for a last step that is cut short by the end of the recording, and
    for a step with a hole.
    """

    t_start_s: float
    reference_m: float
    residual_peak_to_peak_m: float | None
    bias_m: float | None
    bias_percent_of_amplitude: float | None
    settling_time_s: float | None
    limit_cycle: bool | None
    limit_cycle_amplitude_m: float | None = None
    limit_cycle_frequency_hz: float | None = None


def summarize_step(step: ReferenceStep, telemetry: FloatArray, sample_time: float) -> StepSummary:
    """Return the numbers of one step.

    Parameters
    ----------
    step : ReferenceStep
        The step.
    telemetry : ndarray, shape (n, 3)
        Rows of (t [s], u [V], q3 [m]) of the whole run.
    sample_time : float
        Sample time of the telemetry [s].
    """
    time, position = telemetry[:, 0], telemetry[:, 2]
    # Half a sample of room: stamps and sample times are rounded differently.
    edges = np.array([step.t_start, step.t_end - step.window, step.t_end]) - 0.5 * sample_time
    first, window, end = (int(index) for index in np.searchsorted(time, edges))
    if step.cut or step.holed or end - window < 2:
        return StepSummary(step.t_start, step.reference, None, None, None, None, None)
    tail = position[window:end]
    final, peak_to_peak = float(tail.mean()), float(np.ptp(tail))
    bias = final - step.reference
    judged = step.window >= SHORTEST_JUDGED
    settling = None
    if judged and step.height is not None:
        settling = settling_time(
            time[first:end],
            step.t_start,
            position[first:end],
            final,
            SETTLING_BAND * step.height,
            step.length - step.window / 3,
        )
    cycle, amplitude, frequency = (
        _limit_cycle_of(tail, sample_time, peak_to_peak, step.scale)
        if judged
        else (None, None, None)
    )
    return StepSummary(
        t_start_s=step.t_start,
        reference_m=step.reference,
        residual_peak_to_peak_m=peak_to_peak,
        bias_m=bias,
        bias_percent_of_amplitude=100 * bias / step.height if step.height else None,
        settling_time_s=settling,
        limit_cycle=cycle,
        limit_cycle_amplitude_m=amplitude,
        limit_cycle_frequency_hz=frequency,
    )


def _limit_cycle_of(
    tail: FloatArray, sample_time: float, peak_to_peak: float, scale: float | None
) -> tuple[bool, float | None, float | None]:
    """Return whether the end of a step is a limit cycle, its amplitude [m] and frequency [Hz]."""
    # No oscillation is larger than all that moves: most steps of most loops are judged by this.
    if scale is not None and peak_to_peak <= LIMIT_CYCLE_THRESHOLD * scale:
        return False, None, None
    oscillation = find_oscillation(tail, sample_time)
    if not has_limit_cycle(oscillation, peak_to_peak, scale):
        return False, None, None
    amplitude = 0.5 * oscillation_peak_to_peak(oscillation, peak_to_peak)
    return True, amplitude, oscillation.frequency


def settling_time(
    time: FloatArray,
    begin: float,
    position: FloatArray,
    final: float,
    band: float,
    latest: float,
) -> float | None:
    """Return when a position comes within a band for good.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Time [s].
    begin : float
        Beginning of the step, from which the answer counts [s].
    position : ndarray, shape (n,)
        Position [m].
    final : float
        Middle of the band [m].
    band : float
        Half of its width [m].
    latest : float
        Time since the beginning after which the band must not be left any more [s].

    Returns
    -------
    float or None
        Time of the first sample of the last stay within the band [s]; None if that is not before
        `latest`.
    """
    last = _last_outside(position, final, band)
    if last is None:
        return 0.0
    if time[last] - begin > latest or last + 1 == time.size:
        return None
    return float(time[last + 1] - begin)


def _last_outside(position: FloatArray, final: float, band: float) -> int | None:
    """Return the last sample that is further than a band from a position; None if none is."""
    # From the end, where a loop that does not settle shows it, and few samples at a time, which are
    # in the processor's cache when they are looked at again.
    for end in range(position.size, 0, -LOOKED_AT_ONCE):
        begin = max(end - LOOKED_AT_ONCE, 0)
        part = position[begin:end]
        if part.max() - final <= band and final - part.min() <= band:
            continue
        outside = np.flatnonzero(np.abs(part - final) > band)
        if outside.size:
            return begin + int(outside[-1])
    return None


def has_limit_cycle(
    oscillation: Oscillation, peak_to_peak: float, height: float | None
) -> bool | None:
    """Tell whether the end of a step is a limit cycle; None without a height to compare with.

    Parameters
    ----------
    oscillation : Oscillation
        What was found in q3 over the window at the end of the step.
    peak_to_peak : float
        Peak to peak of q3 in that window [m].
    height : float or None
        Height of the step [m].
    """
    if height is None:
        return None
    size = oscillation_peak_to_peak(oscillation, peak_to_peak)
    return oscillation.sustained and size > LIMIT_CYCLE_THRESHOLD * height


def oscillation_peak_to_peak(oscillation: Oscillation, peak_to_peak: float) -> float:
    """Return the peak to peak of an oscillation [m], without drift and noise.

    Parameters
    ----------
    oscillation : Oscillation
        What was found in q3 over the window at the end of the step.
    peak_to_peak : float
        Peak to peak of q3 in that window [m].
    """
    # Smoothing takes a little from the peaks; with noise or drift it takes more, and should.
    is_clean = oscillation.amplitude >= CLEAN * peak_to_peak
    return peak_to_peak if is_clean else oscillation.amplitude
