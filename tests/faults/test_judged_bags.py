"""Bags of a loop with faults: what is wrong with one is found, and what is not is not."""

import shutil
from collections import Counter

import pytest
from judged_bags import lost_by_recorder, wrong_with_bag

from bdt_bags.reading.bag_reader import read_bag
from bdt_msgs_py.topics import MEASUREMENT


@pytest.fixture(scope="module")
def bag(shortest_loop, tmp_path_factory):
    return shortest_loop.write(tmp_path_factory.mktemp("judged") / "bag")


@pytest.fixture
def said(bag):
    return {topic.name: Counter(raw.data) for topic, raw in read_bag(bag).topics.items()}


@pytest.fixture
def torn_bag(bag, tmp_path):
    torn = shutil.copytree(bag, tmp_path / "bag")
    (file,) = torn.glob("*.mcap")
    file.write_bytes(file.read_bytes()[:-2000])
    return torn


def first(said):
    return next(iter(said[MEASUREMENT.name]))


def test_a_whole_bag_of_what_was_said_is_right(bag, said):
    assert wrong_with_bag(bag, said, was_killed=False) == ""
    assert lost_by_recorder(bag, said) == ""


def test_a_message_that_nobody_has_said_makes_a_bag_wrong(bag, said):
    del said[MEASUREMENT.name][first(said)]
    assert "1 messages of measurement nobody" in wrong_with_bag(bag, said, was_killed=False)


def test_a_message_that_was_said_once_and_recorded_twice_makes_a_bag_wrong(bag, said):
    said[MEASUREMENT.name].subtract([first(said)])
    assert "1 messages of measurement nobody" in wrong_with_bag(bag, said, was_killed=False)


def test_a_torn_bag_is_right_only_when_its_recorder_was_killed(torn_bag, said):
    assert "recover" in wrong_with_bag(torn_bag, said, was_killed=False)
    assert wrong_with_bag(torn_bag, said, was_killed=True) == ""


def test_of_a_recorder_that_was_killed_before_it_had_begun_there_is_no_bag(tmp_path, said):
    assert wrong_with_bag(tmp_path / "none", said, was_killed=True) == ""
    assert "does not exist" in wrong_with_bag(tmp_path / "none", said, was_killed=False)


def test_a_message_that_was_said_in_between_is_missed(bag, said):
    order = list(said[MEASUREMENT.name])
    said[MEASUREMENT.name] = Counter([order[0], b"another one", *order[1:]])
    assert lost_by_recorder(bag, said) == "bag: 1 messages of measurement are missing"
