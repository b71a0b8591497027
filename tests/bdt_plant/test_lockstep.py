"""When the followers of a lockstep plant hold it."""

import numpy as np
import pytest

from bdt_msgs_py.rejection import MessageRejectedError, Reason
from bdt_msgs_py.telemetry_sequence import TelemetrySequence
from bdt_msgs_py.time_sequence import SILENCE
from bdt_plant.lockstep import RESTART_SILENCE, Followers

SECOND = 1_000_000_000


def test_without_followers_nothing_holds_the_plant():
    followers = Followers([])
    followers.telemetry_published(SECOND)
    assert followers.blocking(SECOND) == []


def test_empty_names_are_nobody():
    # ROS has no empty lists of texts, so "nobody" is a list with an empty text.
    assert len(Followers([""])) == 0
    assert len(Followers(["", "twin", ""])) == 1


def test_a_name_given_twice_is_one_follower():
    assert len(Followers(["twin", "twin"])) == 1


def test_a_follower_that_has_not_spoken_holds_the_plant_at_the_start():
    assert Followers(["twin"]).blocking(0) == ["twin"]


def test_a_follower_that_took_the_newest_telemetry_lets_the_plant_go():
    followers = Followers(["twin"])
    followers.telemetry_published(SECOND)
    assert followers.progress("twin", SECOND, 100 * SECOND)
    assert followers.blocking(2 * SECOND) == []


def test_the_first_telemetry_is_awaited():
    # Before it a follower cannot know when it will act.
    followers = Followers(["twin"])
    followers.progress("twin", 0, 100 * SECOND)
    followers.telemetry_published(SECOND)
    assert followers.blocking(SECOND) == ["twin"]


@pytest.mark.parametrize(
    ("batch", "batches"), [(SECOND // 100, 20), (SECOND // 10, 10), (2 * SECOND, 0)]
)
def test_the_plant_runs_ahead_of_a_follower_by_20_batches_or_one_second(batch, batches):
    followers = Followers(["twin"])
    followers.telemetry_published(batch)
    followers.progress("twin", batch, 100 * SECOND)
    for ahead in range(1, batches + 1):
        followers.telemetry_published(batch + ahead * batch)
        assert followers.blocking(SECOND) == []
        assert followers.lagging() == ["twin"]
    followers.telemetry_published((batches + 2) * batch)
    assert followers.blocking(SECOND) == ["twin"]


@pytest.mark.parametrize("step", [5e-4, 5e-5])
@pytest.mark.parametrize("duration", [0.05, 0.1, 0.6])
def test_who_lost_all_that_the_plant_ran_ahead_believes_the_newest_telemetry(duration, step):
    """Else the plant would wait for ever: it sends no other."""
    followers, sequence = Followers(["twin"]), TelemetrySequence()
    count = round(duration / step)

    def published(number):
        rows = np.zeros((count, 3))
        rows[:, 0] = step * np.arange(1 + number * count, 1 + (number + 1) * count)
        followers.telemetry_published(round(rows[-1, 0] * SECOND))
        return rows

    sequence.admit(published(0), 0.0)
    followers.progress("twin", round(duration * SECOND), 100 * SECOND)
    number = 1
    while not followers.blocking(SECOND):
        newest = published(number)
        number += 1
    assert not sequence.admit(newest, 10.0).batches
    [admitted] = sequence.admit(newest, 10.0 + 1.1 * SILENCE).batches
    assert admitted is newest


def test_nobody_is_behind_who_has_the_newest_telemetry():
    followers = Followers(["twin", "recorder"])
    followers.telemetry_published(SECOND)
    followers.progress("twin", SECOND, SECOND)
    assert followers.lagging() == ["recorder"]


def test_a_follower_holds_the_plant_from_the_time_at_which_it_acts():
    followers = Followers(["twin"])
    followers.progress("twin", 0, 5 * SECOND)
    assert followers.blocking(5 * SECOND - 1) == []
    assert followers.blocking(5 * SECOND) == ["twin"]
    assert followers.blocking(6 * SECOND) == ["twin"]


def test_a_follower_that_has_acted_lets_the_plant_go_on():
    followers = Followers(["twin"])
    followers.progress("twin", 0, 5 * SECOND)
    followers.progress("twin", 0, 9 * SECOND)
    assert followers.blocking(5 * SECOND) == []


def test_everybody_who_holds_is_named_and_nobody_else():
    followers = Followers(["twin", "recorder", "viewer"])
    followers.telemetry_published(SECOND)
    followers.progress("twin", SECOND, 3 * SECOND)
    followers.progress("recorder", SECOND, 100 * SECOND)
    followers.progress("viewer", SECOND - 1, 100 * SECOND)
    assert followers.blocking(2 * SECOND) == ["viewer"]
    assert followers.blocking(3 * SECOND) == ["twin", "viewer"]


def test_the_word_of_a_stranger_changes_nothing():
    followers = Followers(["twin"])
    assert not followers.progress("stranger", SECOND, SECOND)
    assert len(followers) == 1
    assert followers.blocking(0) == ["twin"]


def test_progress_from_the_past_changes_nothing():
    followers = Followers(["twin"])
    followers.telemetry_published(SECOND)
    followers.progress("twin", SECOND, 9 * SECOND)
    with pytest.raises(MessageRejectedError, match=r"until 0\.5 s: must be 1 to 1 s") as caught:
        followers.progress("twin", SECOND // 2, 0)
    assert caught.value.reason is Reason.TIME
    assert followers.blocking(2 * SECOND) == []


def test_nobody_has_worked_on_telemetry_that_is_still_to_come():
    followers = Followers(["twin"])
    followers.telemetry_published(SECOND)
    with pytest.raises(MessageRejectedError):
        followers.progress("twin", 2 * SECOND, 9 * SECOND)
    assert followers.blocking(0) == ["twin"]


def test_a_follower_of_a_run_before_this_one_has_seen_nothing_of_it():
    followers = Followers(["twin"])
    followers.progress("twin", 100 * SECOND, 200 * SECOND)
    assert followers.blocking(0) == []
    followers.telemetry_published(SECOND)
    assert followers.blocking(0) == ["twin"]


def test_stuck_are_those_who_have_not_come_on_since_a_time_whatever_they_and_others_say():
    followers = Followers(["twin", "recorder"])
    followers.telemetry_published(2 * SECOND)
    followers.progress("twin", SECOND, SECOND, now=1.0)
    followers.progress("recorder", SECOND, SECOND, now=1.0)
    followers.progress("twin", SECOND, SECOND, now=5.0)
    followers.progress("recorder", 2 * SECOND, SECOND, now=5.0)
    assert followers.stuck(["twin", "recorder"], since=3.0) == ["twin"]
    assert followers.stuck(["recorder"], since=3.0) == []
    assert followers.stuck(["twin", "recorder"], since=0.5) == []
    assert Followers(["twin"]).stuck(["twin"], since=0.0) == ["twin"]


def test_a_later_promise_is_progress_a_broken_one_is_none():
    followers = Followers(["twin"])
    followers.progress("twin", 0, 5 * SECOND, now=1.0)
    followers.progress("twin", 0, 4 * SECOND, now=5.0)
    assert followers.stuck(["twin"], since=3.0) == ["twin"]
    followers.progress("twin", 0, 6 * SECOND, now=6.0)
    assert followers.stuck(["twin"], since=3.0) == []


def follower_at(end, now):
    followers = Followers(["twin"])
    followers.telemetry_published(SECOND)
    followers.telemetry_published(2 * SECOND)
    followers.telemetry_published(3 * SECOND)
    followers.progress("twin", end, 5 * SECOND, now=now)
    return followers


def test_a_follower_that_is_started_anew_is_believed_once_the_one_before_is_silent():
    followers = follower_at(SECOND, now=1.0)
    assert followers.blocking(3 * SECOND) == ["twin"]
    with pytest.raises(MessageRejectedError):
        followers.progress("twin", 0, 100 * SECOND, now=1.0 + 0.9 * RESTART_SILENCE)
    assert followers.blocking(3 * SECOND) == ["twin"]
    assert followers.progress("twin", 0, 100 * SECOND, now=1.0 + RESTART_SILENCE)
    assert followers.blocking(3 * SECOND) == [], "what it has lost never comes"
    assert followers.stuck(["twin"], since=1.0) == []


def test_the_first_telemetry_of_a_follower_that_is_started_anew_is_awaited():
    followers = follower_at(3 * SECOND, now=1.0)
    followers.progress("twin", 0, 100 * SECOND, now=10.0)
    followers.telemetry_published(4 * SECOND)
    assert followers.blocking(4 * SECOND) == ["twin"], "the others may be a second ahead"
    followers.progress("twin", 4 * SECOND, 6 * SECOND, now=10.1)
    followers.telemetry_published(5 * SECOND)
    assert followers.blocking(5 * SECOND) == []


def test_a_second_follower_of_the_name_changes_nothing_while_the_first_one_speaks():
    followers = follower_at(3 * SECOND, now=1.0)
    for tick in range(1, 100):
        now = 1.0 + 0.1 * tick
        followers.progress("twin", 3 * SECOND, 5 * SECOND, now=now)
        with pytest.raises(MessageRejectedError):
            followers.progress("twin", 0, 100 * SECOND, now=now + 0.05)
    assert followers.blocking(5 * SECOND) == ["twin"], "the promise of the first one holds"
