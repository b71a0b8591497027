"""A bag as a stream: all of it, at its pace, as often as wanted."""

import json
import select
import threading
import time
from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest

from bdt_bags.reading.recording import load_recording
from bdt_bags.run_signals import RunSignals
from bdt_live.bag_process import BagShow
from bdt_live.channel import Channel, channel_pair
from bdt_live.extremes import COLUMNS
from bdt_live.from_server import page_asks, page_has_come
from bdt_live.playback import Playback
from bdt_msgs_py.stop_signals import StopSignals

DEADLINE = 60.0
"""Wall time [s] after which a condition counts as never met."""


@pytest.fixture
def run():
    times = np.arange(10_000) / 5000 + 3.0
    truth = np.zeros((1000, 7))
    truth[:, 0], truth[:, 3] = times[::10], 0.1
    return RunSignals(
        telemetry=np.column_stack([times, np.zeros(times.size), np.sin(times)]),
        truth=truth,
        reference=np.array([[3.0, 0.005], [4.0, 0.0]]),
        estimates=np.empty((0, 2)),
        dead_zones=np.array([[3.5, 1e-5]]),
        pitch=None,
    )


def column(rows, name):
    return [row[COLUMNS.index(name)] for row in rows]


def test_a_run_is_played_at_its_pace(run):
    playback = Playback(run)
    playback.pace = 2.0
    rows = playback.advance(0.5)
    assert column(rows, "time")[0] == 3.0
    assert column(rows, "time")[-1] == pytest.approx(3.99)


def test_every_row_is_played_once_and_the_end_is_a_pause(run):
    playback, rows = Playback(run), []
    while not playback.is_paused:
        rows += playback.advance(0.04)
    assert playback.is_over
    np.testing.assert_allclose(column(rows, "time"), 3.0 + 0.01 * np.arange(199))
    assert set(column(rows, "gap")) == {0.1}


def test_what_holds_changes_when_the_run_says_so(run):
    playback = Playback(run)
    first, second, third = (playback.advance(0.4)[-1] for _ in range(3))
    of = COLUMNS.index
    assert (first[of("reference")], first[of("dead_zone")]) == (0.005, None)
    assert (second[of("reference")], second[of("dead_zone")]) == (0.005, 1e-5)
    assert (third[of("reference")], third[of("estimate")]) == (0.0, None)


def test_what_holds_changes_at_its_time_however_fast_a_run_is_played(run):
    playback = Playback(run)
    playback.pace = 10.0
    rows = playback.advance(0.15)
    reference = dict(zip(column(rows, "time"), column(rows, "reference"), strict=True))
    assert (reference[3.99], reference[4.0]) == (0.005, 0.0)


def test_what_holds_is_that_of_the_beginning_after_a_rewind(run):
    playback = Playback(run)
    playback.advance(2.0)
    playback.rewind()
    playback.is_paused = False
    assert set(column(playback.advance(0.4), "reference")) == {0.005}


def test_paused_it_goes_on_by_steps_alone(run):
    playback = Playback(run)
    playback.advance(0.1)
    playback.is_paused = True
    assert playback.advance(1.0) == []
    assert len(playback.step()) == 4


def told(recording, requests, is_enough):
    """Return what a page is told of a bag that is played, by the type of the messages."""
    own, other = (Channel(end) for end in channel_pair())
    playing = threading.Thread(
        target=BagShow(other, recording).run, args=(StopSignals(),), daemon=True
    )
    playing.start()
    own.send(page_has_come())
    for number, request in enumerate(requests):
        own.send(page_asks(1, json.dumps({"number": number, **request})))
    heard = defaultdict(list)
    end = time.monotonic() + DEADLINE
    while not is_enough(heard):
        assert time.monotonic() < end
        select.select([own], [], [], 0.1)
        for text in own.receive():
            message = json.loads(text)
            heard[message["type"]].append(message)
    own.close()
    playing.join(timeout=DEADLINE)
    assert not playing.is_alive()
    other.close()
    return heard


FAST = {"action": "pace", "amount": 10}


def test_a_bag_is_told_to_the_page_which_may_pause_and_not_set(following_bag):
    heard = told(
        replace(load_recording(following_bag), marks=(0.5, 1e3)),
        [FAST, {"action": "wear"}],
        lambda heard: heard["state"] and any(each["times"] for each in heard["marks"]),
    )
    reasons = [each["reason"] for each in heard["reply"]]
    assert reasons == [None, "a bag is played back: there is no loop to ask"]
    assert (heard["state"][0]["word"], heard["state"][0]["over"]) == ("a bag is played back", False)
    assert len(heard["frame"][0]["rows"][0]) == len(COLUMNS)
    assert heard["marks"][-1]["times"] == [0.5]


def test_the_end_of_a_bag_is_told(following_bag):
    recording = load_recording(following_bag)
    short = replace(recording, telemetry=recording.telemetry[:1000])
    heard = told(short, [FAST], lambda heard: heard["state"] and heard["state"][-1]["over"])
    last = heard["state"][-1]
    assert (last["word"], last["paused"]) == ("the end of the bag", True)
