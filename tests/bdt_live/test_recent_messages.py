"""The last minute of a loop."""

from bdt_bags.writing.topic_metadata import SerializedMessage, topic_metadata
from bdt_live.recent_messages import DURATION, LastMessage, RecentMessages, write_bag

SECOND = 1_000_000_000


def topic(name):
    return topic_metadata(f"/{name}", "std_msgs/msg/Float64MultiArray", "")


def filled(seconds):
    recent = RecentMessages()
    held = recent.add_topic(topic("reference"), LastMessage())
    running = recent.add_topic(topic("telemetry"))
    recent.add(SerializedMessage(held, 1, 1, b"first"))
    recent.add(SerializedMessage(held, 2, 2, b"second"))
    for second in range(1, seconds):
        recent.add(SerializedMessage(running, second * SECOND, second * SECOND, b"x"))
    return recent


def test_older_messages_are_forgotten():
    messages = filled(200).messages()
    assert messages[-1].received - messages[1].received == DURATION


def test_what_has_held_since_before_comes_first():
    messages = filled(200).messages()
    assert messages[0].data == b"second"
    assert messages[0].received == messages[1].received


def test_what_is_young_is_there_as_it_came():
    assert [message.data for message in filled(3).messages()] == [b"first", b"second", b"x", b"x"]


def test_the_memory_is_bounded():
    recent = RecentMessages()
    number = recent.add_topic(topic("telemetry"))
    data = bytes(1 << 20)
    for n in range(300):
        recent.add(SerializedMessage(number, n, n, data))
    assert len(recent.messages()) == 128


def test_they_become_a_bag(tmp_path):
    recent = filled(5)
    write_bag(tmp_path / "bag", recent.topics, recent.messages())
    assert (tmp_path / "bag" / "metadata.yaml").is_file()
