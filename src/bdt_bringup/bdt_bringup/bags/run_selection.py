"""Runs in one bag: the recorder went on while the loop was started again."""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from bdt_bringup.bags.bag_error import BagError
from bdt_bringup.bags.bag_reader import RawBag, RawTopic

FloatArray = NDArray[np.float64]

STRAGGLERS = 300_000_000
"""Time [ns] after the last sample of a run for which messages still belong to it: the last
estimate takes a while, and a node that is started again takes longer to be there."""


def run_limits(times: FloatArray, received: Sequence[int]) -> list[int]:
    """Return when the runs of a bag begin, the first one left out.

    A run begins where time goes back and goes on from there. A message that is repeated, or one
    that comes late among newer ones, begins no run.

    Parameters
    ----------
    times : ndarray, shape (k,)
        Time of the data in each message of a topic [s]; NaN where it has none.
    received : sequence of int, length k
        Receive times of these messages [ns].

    Returns
    -------
    list of int
        Receive times [ns] from which on messages belong to the next run; one less than runs.
    """
    known = sorted(
        (x for x in zip(received, times.tolist(), strict=True) if math.isfinite(x[1])),
        key=itemgetter(0),
    )
    limits, newest = [], -math.inf
    for index, ((arrival, time), (_, following)) in enumerate(pairwise(known)):
        if time < newest and following < newest:
            # What comes before the first sample, such as a node's parameters, is of the new run.
            limits.append(min(known[index - 1][0] + STRAGGLERS, arrival))
            newest = time
        newest = max(newest, time)
    return limits


def select_run(bag: RawBag, limits: Sequence[int], number: int) -> RawBag:
    """Return what belongs to one run of a bag.

    Parameters
    ----------
    bag : RawBag
        A bag.
    limits : sequence of int
        Where its runs part; see :func:`run_limits`.
    number : int
        Which run, from 1.

    Returns
    -------
    RawBag
        Only topics that were read are counted, and only the messages of the run.

    Raises
    ------
    BagError
        If the bag does not hold so many runs.
    """
    runs = len(limits) + 1
    if not 1 <= number <= runs:
        held = f"{runs} runs" if runs > 1 else "one run"
        raise BagError(f"bag {bag.path}: holds {held}: --run {number} is none of them")
    begin, end = [None, *limits, None][number - 1 : number + 1]
    topics = {topic: _between(raw, begin, end) for topic, raw in bag.topics.items()}
    topics = {topic: raw for topic, raw in topics.items() if raw.data}
    return RawBag(bag.path, topics, {raw.name: len(raw.data) for raw in topics.values()})


def _between(raw: RawTopic, begin: int | None, end: int | None) -> RawTopic:
    """Return the messages received from `begin` on, before `end` [ns]; None is unlimited."""
    kept = [
        (received, data)
        for received, data in zip(raw.received, raw.data, strict=True)
        if (begin is None or begin <= received) and (end is None or received < end)
    ]
    return replace(raw, received=[x for x, _ in kept], data=[x for _, x in kept])
