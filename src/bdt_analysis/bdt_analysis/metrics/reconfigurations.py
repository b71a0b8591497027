"""Log of the reconfigurations: every dead zone, the estimate behind it, and how late it came."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_analysis.metrics.dead_zone_requests import dead_zone_requests, matching_requests
from bdt_bags.reading.recording import Recording
from bdt_bags.run_signals import RunSignals

FloatArray = NDArray[np.float64]


class Reconfiguration(NamedTuple):
    """One change of the dead zone.

    Attributes
    ----------
    time_s : float
        Time at which it took effect [s].
    dead_zone_m : float
        Dead-zone tolerance from then on [m].
    change_m : float or None
        Difference to the tolerance before [m]; None for the first one known.
    estimate_time_s, estimate_rad : float or None
        Time for which the estimate behind this dead zone is stated [s], and the estimate [rad];
        None when the value belongs to no estimate: somebody else set it.
    delay_s : float or None
        Time from the newest sample behind the estimate to the reconfiguration [s].
    gap_age_s : float or None
        Time from `estimate_time_s` to the reconfiguration [s]; longer than the delay when the
        estimator states the gap for a time before its newest sample.
    """

    time_s: float
    dead_zone_m: float
    change_m: float | None
    estimate_time_s: float | None
    estimate_rad: float | None
    delay_s: float | None
    gap_age_s: float | None


@dataclass(frozen=True)
class ReconfigurationSummary:
    """Delays of reconfigurations; the fields of ``reconfiguration_delay`` in ``summary.json``.

    Attributes
    ----------
    from_estimates : int or None
        Number of dead zones that are those of an estimate; None, as the next two, where nothing
        tells when the dead zone was set.
    from_elsewhere : int or None
        Number of the others, the initial one not counted.
    estimates_not_applied : int or None
        Number of estimates that no dead zone followed.
    min_s, median_s, max_s : float or None
        Delay from the newest sample behind an estimate to its dead zone [s].
    max_gap_age_s : float or None
        Longest time from that for which an estimate is stated to its dead zone [s].
    longest_pause_s : float or None
        Longest time between two reconfigurations [s].
    """

    from_estimates: int | None
    from_elsewhere: int | None
    estimates_not_applied: int | None
    min_s: float | None
    median_s: float | None
    max_s: float | None
    max_gap_age_s: float | None
    longest_pause_s: float | None


def reconfiguration_log(run: RunSignals) -> list[Reconfiguration]:
    """Return every dead zone of a run in the order of time, the initial one included.

    Parameters
    ----------
    run : RunSignals
        A run.
    """
    requests = dead_zone_requests(run)
    matches = matching_requests(requests, run.dead_zones).tolist()
    log: list[Reconfiguration] = []
    for (time, value), match in zip(run.dead_zones.tolist(), matches, strict=True):
        newest, _, stated, gap = requests[match].tolist() if match >= 0 else (None,) * 4
        log.append(
            Reconfiguration(
                time_s=time,
                dead_zone_m=value,
                change_m=value - log[-1].dead_zone_m if log else None,
                estimate_time_s=stated,
                estimate_rad=gap,
                delay_s=None if newest is None else time - newest,
                gap_age_s=None if stated is None else time - stated,
            )
        )
    return log


def summarize_reconfigurations(recording: Recording) -> ReconfigurationSummary:
    """Return the delays of a recording in numbers.

    Parameters
    ----------
    recording : Recording
        A loaded bag.
    """
    if recording.reconfigurations is None:
        return ReconfigurationSummary(*(None,) * 8)
    log = reconfiguration_log(recording)
    delays = np.array([entry.delay_s for entry in log if entry.delay_s is not None])
    ages = [entry.gap_age_s for entry in log if entry.gap_age_s is not None]
    initial = len(log) - recording.reconfigurations
    others = len(log) - delays.size - initial
    pauses = np.diff([entry.time_s for entry in log[max(initial, 0) :]])
    return ReconfigurationSummary(
        from_estimates=delays.size,
        from_elsewhere=max(others, 0),
        estimates_not_applied=len(recording.estimates) - delays.size,
        min_s=float(delays.min()) if delays.size else None,
        median_s=float(np.median(delays)) if delays.size else None,
        max_s=float(delays.max()) if delays.size else None,
        max_gap_age_s=max(ages, default=None),
        longest_pause_s=float(pauses.max()) if pauses.size else None,
    )
