"""Which messages of a topic belong to which run, and which to none: strays of other publishers.

A bag does not tell who published a message. What tells is time: a run goes on from message to
message, also past late and repeated ones. What fits nowhere into that is a stray.
"""

import math
from bisect import bisect_right
from collections.abc import Sequence
from operator import itemgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

STRAY = -1
"""Number of the run of a message that belongs to none."""

_STEP = 5
"""Longest step from a message to one that goes on from it without a doubt [usual steps]."""

REACH = 50
"""Time by which a run may step forward beyond what its pace explains, and by which a message may
be early among the others [usual steps]."""

_PATIENCE = 20
"""Messages of others after which nothing is expected to go on where an earlier one stopped."""

_PACE_MARGIN = 10.0
"""A run that goes on after a gap has not gone faster meanwhile than this times its usual pace."""

_ROOM = 0.75
"""A message has its place in a run if it keeps this from its neighbors [usual gaps]."""

_REGULAR = 0.05
"""Steps that differ by less from the usual one [usual steps] are those of a regular grid."""


class MessageSpans(NamedTuple):
    """Which times the messages of a topic tell of, in any order.

    Attributes
    ----------
    begins, ends : ndarray, shape (k,)
        First and last time in each message [s]; NaN for one that tells none. They are the same
        for a message with one stamp.
    received : sequence of int, length k
        Receive times [ns].
    data : sequence of bytes, length k
        Content, to tell a repeated message from another one for the same time.
    """

    begins: FloatArray
    ends: FloatArray
    received: Sequence[int]
    data: Sequence[bytes]


def runs_of_messages(spans: MessageSpans) -> IntArray:
    """Return to which run each message belongs.

    A run begins where time goes back and goes on from there, for two different times at least. A
    message that is repeated belongs to the run, as does one that comes late and has its place
    there. One for the same time with another content is a stray, unless it comes first.

    Parameters
    ----------
    spans : MessageSpans
        Messages of one topic.

    Returns
    -------
    ndarray of int, shape (k,)
        Numbers of runs from 0 on, :data:`STRAY` for a message that belongs to none.
    """
    found = np.full(len(spans.begins), STRAY, np.int64)
    told = np.flatnonzero(np.isfinite(spans.begins) & (spans.begins <= spans.ends))
    # Receive times of 1970 in nanoseconds are exact as integers only.
    order = told[np.argsort(np.array(spans.received, np.int64)[told], kind="stable")]
    if not order.size:
        return found
    places = order.tolist()
    messages = _Messages(
        spans.begins[order],
        spans.ends[order],
        np.array([spans.received[k] - spans.received[places[0]] for k in places]) / 1e9,
        [spans.data[k] for k in places],
    )
    numbers = np.full(order.size, STRAY, np.int64)
    step = _usual(np.diff(messages.begins))
    for number, run in enumerate(_runs(messages, _chains(messages, step), step)):
        numbers[run] = number
    for number in range(int(numbers.max()) + 1):
        _remove_intruders(messages, numbers, number)
    _place_late_ones(messages, numbers, step)
    _remove_contradictions(messages, numbers)
    found[order] = numbers
    return found


class _Messages(NamedTuple):
    """Messages that tell a time, in the order of their reception."""

    begins: FloatArray
    ends: FloatArray
    received: FloatArray
    data: list[bytes]


def _usual(steps: FloatArray) -> float:
    """Return the median of what is above zero; infinite without any."""
    forward = steps[steps > 0]
    return float(np.median(forward)) if forward.size else math.inf


def _chains(messages: _Messages, step: float) -> list[IntArray]:
    """Return messages that go on from each other, as positions in the order of reception."""
    begins, ends = messages.begins.tolist(), messages.ends.tolist()
    gaps = messages.begins[1:] - messages.ends[:-1]
    gap, longest = _usual(gaps), _STEP * step
    same = (np.diff(messages.begins) == 0) & (np.diff(messages.ends) == 0)
    if (same | ((gaps >= 0) & (gaps <= longest))).all():
        return [np.arange(len(begins))]
    chains: list[list[int]] = []
    alive: list[list[int]] = []
    for k, begin in enumerate(begins):
        best, least = None, math.inf
        for chain in alive:
            last = chain[-1]
            found = begin - ends[last]
            unlike = abs(found - gap)
            if begin == begins[last] and ends[k] == ends[last] and chain is alive[-1]:
                best, least = chain, -1.0  # the last one, repeated
            # Of two that are alike, the one that went on last: a run may repeat another one.
            elif 0 <= found <= longest and unlike <= least:
                best, least = chain, unlike
        if best is None:
            best = []
            chains.append(best)
        else:
            alive.remove(best)
        best.append(k)
        alive = [chain for chain in alive if k - chain[-1] < _PATIENCE] + [best]
    return [np.array(chain) for chain in chains]


def _runs(messages: _Messages, chains: list[IntArray], step: float) -> list[IntArray]:
    """Return the messages of each run, in the order of reception."""
    accepted: list[IntArray] = []
    for chain in sorted(chains, key=len, reverse=True):
        place = bisect_right(accepted, chain[0], key=itemgetter(0))
        alone = (not place or accepted[place - 1][-1] < chain[0]) and (
            place == len(accepted) or chain[-1] < accepted[place][0]
        )
        if not accepted or (alone and np.unique(messages.begins[chain]).size > 1):
            accepted.insert(place, chain)
    runs = [accepted[0]]
    for chain in accepted[1:]:
        before = _without_tail(messages, runs[-1], float(messages.begins[chain[0]]))
        gap = messages.begins[chain[0]] - messages.ends[before[-1]]
        pause = messages.received[chain[0]] - messages.received[before[-1]]
        pace = max(_pace(messages, before), _pace(messages, chain))
        if 0 <= gap <= REACH * step + _PACE_MARGIN * pace * pause:
            runs[-1] = np.concatenate([before, chain])  # a gap, and on
        else:
            runs.append(chain)
    return runs


def _without_tail(messages: _Messages, run: IntArray, time: float) -> IntArray:
    """Return a run without those last messages that are ahead of the time at which it goes on.

    They are strays of a time so near that the run seemed to go on with them.
    """
    kept = run[messages.ends[run] < time]
    few = run.size - kept.size <= min(_PATIENCE, run.size // 2)
    return kept if kept.size and few else run


def _pace(messages: _Messages, chain: IntArray) -> float:
    """Return the time of the data per time of reception."""
    wall = messages.received[chain[-1]] - messages.received[chain[0]]
    return float((messages.ends[chain[-1]] - messages.begins[chain[0]]) / wall) if wall else 0.0


def _remove_intruders(messages: _Messages, numbers: IntArray, number: int) -> None:
    """Remove what stands between two messages of a regular grid."""
    run = np.flatnonzero(numbers == number)
    gaps = messages.begins[run[1:]] - messages.ends[run[:-1]]
    usual = _usual(gaps)
    if math.isinf(usual) or np.mean(np.abs(gaps / usual - 1) < _REGULAR) < 1 - 2 * _REGULAR:
        return
    both = messages.begins[run[2:]] - messages.ends[run[:-2]]
    narrow = (gaps > 0) & (gaps < _ROOM * usual)
    between = narrow[1:] & narrow[:-1] & (np.abs(both / usual - 1) < _REGULAR)
    numbers[run[1:-1][between]] = STRAY


def _place_late_ones(messages: _Messages, numbers: IntArray, step: float) -> None:
    """Give a message that is left to the run during which it came, if it has its place there."""
    begins = np.sort(messages.begins)
    room = _ROOM * _usual(begins[1:] - messages.ends[np.argsort(messages.begins)][:-1])
    tables = [
        _RunTable.of(messages, np.flatnonzero(numbers == number))
        for number in range(int(numbers.max()) + 1)
    ]
    firsts = [int(table.positions[0]) for table in tables]
    for k in np.flatnonzero(numbers == STRAY).tolist():
        number = max(bisect_right(firsts, k) - 1, 0)
        if tables[number].has_place_for(messages, k, step, room):
            numbers[k] = number


class _RunTable(NamedTuple):
    """The messages of a run: positions in the order of reception, the rest in that of time."""

    positions: IntArray
    begins: FloatArray
    ends: FloatArray
    data: list[bytes]

    @classmethod
    def of(cls, messages: _Messages, positions: IntArray) -> "_RunTable":
        order = positions[np.argsort(messages.begins[positions], kind="stable")]
        data = [messages.data[k] for k in order.tolist()]
        return cls(positions, messages.begins[order], messages.ends[order], data)

    def has_place_for(self, messages: _Messages, k: int, step: float, room: float) -> bool:
        """Tell whether a message repeats one of the run or has room between two of them."""
        begin, end = messages.begins[k], messages.ends[k]
        following = int(np.searchsorted(self.positions, k))
        # Nothing comes before its time.
        if (
            following < self.positions.size
            and begin > REACH * step + (messages.begins[self.positions[following]])
        ):
            return False
        place = int(np.searchsorted(self.begins, begin, side="left"))
        if place < self.begins.size and (self.begins[place], self.ends[place]) == (begin, end):
            return self.data[place] == messages.data[k]
        # Just before the first one and just behind the last one there is room as well.
        before = begin - self.ends[place - 1] if place else _STEP * step
        after = self.begins[place] - end if place < self.begins.size else _STEP * step
        outside = not 0 < place < self.begins.size
        return bool(
            min(before, after) > room and not (outside and max(before, after) > _STEP * step)
        )


def _remove_contradictions(messages: _Messages, numbers: IntArray) -> None:
    """Remove messages for a time for which another one, of other content, came first."""
    order = np.lexsort((np.arange(numbers.size), messages.begins, numbers))
    order = order[numbers[order] != STRAY]
    same = (np.diff(messages.begins[order]) == 0) & (np.diff(numbers[order]) == 0)
    first = 0
    for place in np.flatnonzero(same).tolist():
        if not place or not same[place - 1]:
            first = order[place]
        if messages.data[order[place + 1]] != messages.data[first]:
            numbers[order[place + 1]] = STRAY
