"""When the followers of a lockstep plant hold it."""

import pytest

from bdt_plant.lockstep import Followers

SECOND = 1_000_000_000


def test_without_followers_nothing_holds_the_plant():
    followers = Followers([])
    followers.telemetry_published(SECOND)
    assert followers.holding(SECOND) == []


def test_empty_names_are_nobody():
    # ROS has no empty lists of texts, so "nobody" is a list with an empty text.
    assert len(Followers([""])) == 0
    assert len(Followers(["", "twin", ""])) == 1


def test_a_name_given_twice_is_one_follower():
    assert len(Followers(["twin", "twin"])) == 1


def test_a_follower_that_has_not_spoken_holds_the_plant_at_the_start():
    assert Followers(["twin"]).holding(0) == ["twin"]


def test_a_follower_that_took_the_newest_telemetry_lets_the_plant_go():
    followers = Followers(["twin"])
    followers.telemetry_published(SECOND)
    assert followers.progress("twin", SECOND, 100 * SECOND)
    assert followers.holding(2 * SECOND) == []


def test_the_first_telemetry_is_awaited():
    # Before it a follower cannot know when it will act.
    followers = Followers(["twin"])
    followers.progress("twin", 0, 100 * SECOND)
    followers.telemetry_published(SECOND)
    assert followers.holding(SECOND) == ["twin"]


@pytest.mark.parametrize(
    ("batch", "batches"), [(SECOND // 100, 20), (SECOND // 10, 10), (2 * SECOND, 0)]
)
def test_the_plant_runs_ahead_of_a_follower_by_20_batches_or_one_second(batch, batches):
    followers = Followers(["twin"])
    followers.telemetry_published(batch)
    followers.progress("twin", batch, 100 * SECOND)
    for ahead in range(1, batches + 1):
        followers.telemetry_published(batch + ahead * batch)
        assert followers.holding(SECOND) == []
        assert followers.behind() == ["twin"]
    followers.telemetry_published((batches + 2) * batch)
    assert followers.holding(SECOND) == ["twin"]


def test_nobody_is_behind_who_has_the_newest_telemetry():
    followers = Followers(["twin", "recorder"])
    followers.telemetry_published(SECOND)
    followers.progress("twin", SECOND, SECOND)
    assert followers.behind() == ["recorder"]


def test_a_follower_holds_the_plant_from_the_time_at_which_it_acts():
    followers = Followers(["twin"])
    followers.progress("twin", 0, 5 * SECOND)
    assert followers.holding(5 * SECOND - 1) == []
    assert followers.holding(5 * SECOND) == ["twin"]
    assert followers.holding(6 * SECOND) == ["twin"]


def test_a_follower_that_has_acted_lets_the_plant_go_on():
    followers = Followers(["twin"])
    followers.progress("twin", 0, 5 * SECOND)
    followers.progress("twin", 0, 9 * SECOND)
    assert followers.holding(5 * SECOND) == []


def test_everybody_who_holds_is_named_and_nobody_else():
    followers = Followers(["twin", "recorder", "viewer"])
    followers.telemetry_published(SECOND)
    followers.progress("twin", SECOND, 3 * SECOND)
    followers.progress("recorder", SECOND, 100 * SECOND)
    followers.progress("viewer", SECOND - 1, 100 * SECOND)
    assert followers.holding(2 * SECOND) == ["viewer"]
    assert followers.holding(3 * SECOND) == ["twin", "viewer"]


def test_the_word_of_a_stranger_changes_nothing():
    followers = Followers(["twin"])
    assert not followers.progress("stranger", SECOND, SECOND)
    assert len(followers) == 1
    assert followers.holding(0) == ["twin"]
