"""Messages between two processes, neither of which waits."""

import json

import pytest

from bdt_live.channel import LONGEST, MOST_WAITING, Channel, channel_pair


@pytest.fixture
def ends():
    pair = [Channel(end) for end in channel_pair()]
    yield pair
    for end in pair:
        end.close()


def test_messages_come_one_by_one_in_their_order(ends):
    ends[0].send({"n": 1})
    ends[0].send({"n": 2})
    assert [json.loads(text)["n"] for text in ends[1].receive()] == [1, 2]
    assert ends[1].receive() == []


def test_for_who_does_not_listen_frames_are_dropped_and_everything_else_is_kept(ends):
    frame = {"frame": "x" * 20_000}
    for _ in range(2 * MOST_WAITING):
        ends[0].send(frame, may_be_dropped=True)
    ends[0].send({"word": "kept"})
    assert ends[0].dropped > 0
    heard = []
    while not (heard and heard[-1] == {"word": "kept"}):
        heard += [json.loads(text) for text in ends[1].receive()]
        ends[0].flush()
    assert len(heard) + ends[0].dropped == 2 * MOST_WAITING + 1


def test_the_end_of_the_other_side_is_told(ends):
    ends[0].send({"n": 1})
    ends[0].close()
    assert ends[1].receive() is not None
    assert ends[1].receive() is None
    ends[1].send({"n": 1})


def test_a_message_has_a_largest_size(ends):
    with pytest.raises(ValueError, match="bytes"):
        ends[0].send({"text": "x" * LONGEST})
