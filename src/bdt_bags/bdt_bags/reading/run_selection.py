"""Runs in one bag: the recorder went on while the loop was started again."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bdt_bags.bag_error import BagError
from bdt_bags.reading.bag_reader import RawBag

IntArray = NDArray[np.int64]

STRAGGLERS = 300_000_000
"""Time [ns] after the last sample of a run for which messages still belong to it: the last
estimate takes a while, and a node that is started again takes longer to be there."""


def run_limits(runs: IntArray, received: Sequence[int]) -> list[int]:
    """Return when the runs of a bag begin, the first one left out.

    Parameters
    ----------
    runs : ndarray of int, shape (k,)
        Run of each message of a topic; see :func:`bdt_bags.reading.message_runs.runs_of_messages`.
    received : sequence of int, length k
        Receive times of these messages [ns].

    Returns
    -------
    list of int
        Receive times [ns] from which on messages belong to the next run; one less than runs.
    """
    limits = []
    for number in range(1, int(runs.max(initial=0)) + 1):
        last = max(received[k] for k in np.flatnonzero(runs == number - 1).tolist())
        first = min(received[k] for k in np.flatnonzero(runs == number).tolist())
        # What comes before the first sample, such as a node's parameters, is of the new run.
        limits.append(min(last + STRAGGLERS, first))
    return limits


def select_run(bag: RawBag, number: int | None) -> RawBag:
    """Return what belongs to one run of a bag.

    Parameters
    ----------
    bag : RawBag
        A bag whose runs are known.
    number : int or None
        Which run, from 1; None for the only one.

    Returns
    -------
    RawBag
        Only topics that were read are counted, and only the messages of the run.

    Raises
    ------
    BagError
        If the bag does not hold so many runs, or several and none is chosen.
    """
    runs = len(bag.run_limits) + 1
    if number is None:
        if runs > 1:
            raise BagError(
                f"bag {bag.path}: time goes back: holds {runs} runs, choose one with "
                f"bdt analyze --run 1 to --run {runs}"
            )
        return bag
    if not 1 <= number <= runs:
        held = f"{runs} runs" if runs > 1 else "one run"
        raise BagError(f"bag {bag.path}: holds {held}: --run {number} is none of them")
    begin, end = [-math.inf, *bag.run_limits, math.inf][number - 1 : number + 1]
    topics = {
        topic: raw.only([begin <= received < end for received in raw.received])
        for topic, raw in bag.topics.items()
    }
    topics = {topic: raw for topic, raw in topics.items() if raw.data}
    left_out = {
        name: [received for received in times if begin <= received < end]
        for name, times in bag.left_out.items()
    }
    counts = {raw.name: len(raw.data) + len(left_out.get(raw.name, ())) for raw in topics.values()}
    return replace(
        bag,
        topics=topics,
        message_counts=counts,
        run_limits=(),
        left_out={name: times for name, times in left_out.items() if times},
    )
