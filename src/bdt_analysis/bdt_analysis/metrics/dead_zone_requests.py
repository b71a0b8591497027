"""Which estimate is behind a dead zone, and how late it came."""

import numpy as np
from numpy.typing import NDArray

from bdt_analysis.metrics.lead_screw_pitch import lead_screw_pitch
from bdt_bags.run_signals import RunSignals
from bdt_twin.dead_zone_tolerance import tolerance_for_gap

FloatArray = NDArray[np.float64]

SAME_VALUE = 1e-9
"""Relative difference below which a dead zone is the one that was asked for."""


def dead_zone_requests(run: RunSignals) -> FloatArray:
    """Return the dead zones that the twin asked for.

    A twin that does not tell them is taken to ask for eq. 9, with an estimate that states the gap
    for its newest sample: that is what the paper's does.

    Parameters
    ----------
    run : RunSignals
        A run.

    Returns
    -------
    ndarray, shape (k, 4)
        See :class:`bdt_bags.run_signals.RunSignals`.
    """
    if len(run.requests):
        return run.requests
    times, gaps = run.estimates.T
    pitch = lead_screw_pitch(run)
    tolerances = [tolerance_for_gap(gap, pitch) for gap in gaps.tolist()]
    return np.stack([times, np.array(tolerances), times, gaps], axis=1)


def matching_requests(requests: FloatArray, dead_zones: FloatArray) -> NDArray[np.intp]:
    """Return which request is behind each dead zone.

    The values themselves tell which one it was; a dead zone that somebody else set belongs to
    none. A request is never behind a dead zone older than its data.

    Parameters
    ----------
    requests : ndarray, shape (k, 4)
        From :func:`dead_zone_requests`.
    dead_zones : ndarray, shape (j, 2)
        Rows of (time [s], dead-zone tolerance [m]) in the order of time.

    Returns
    -------
    ndarray of int, shape (j,)
        Rows of `requests`, increasing; -1 for none.
    """
    newest_samples, tolerances = requests[:, 0], requests[:, 1]
    following = 0
    matches = np.full(len(dead_zones), -1, np.intp)
    for number, (time, value) in enumerate(dead_zones.tolist()):
        newest = int(np.searchsorted(newest_samples, time, side="right"))
        same = np.isclose(tolerances[following:newest], value, rtol=SAME_VALUE, atol=0.0)
        if same.any():
            # Requests are delivered in order: the first one not yet delivered is meant.
            matches[number] = following + int(np.argmax(same))
            following = int(matches[number]) + 1
    return matches


def reconfiguration_lags(run: RunSignals) -> FloatArray:
    """Return how long after its data each estimate reached the controller.

    The lag of a reconfiguration runs from the newest sample behind the estimate to the time at
    which the dead zone took the value that was asked for. It holds what was left of the batch, the
    communication delay and the service call. It does not hold the window over which the estimator
    averages, nor the age of the gap at that sample: an estimator by output error states the gap
    at the last reversal of the screw, however long ago that was.

    Parameters
    ----------
    run : RunSignals
        A run.

    Returns
    -------
    ndarray, shape (i, 2)
        Rows of (time of the reconfiguration [s], lag [s]).
    """
    requests = dead_zone_requests(run)
    matches = matching_requests(requests, run.dead_zones)
    known = matches >= 0
    times = run.dead_zones[known, 0]
    return np.stack([times, times - requests[matches[known], 0]], axis=1)
