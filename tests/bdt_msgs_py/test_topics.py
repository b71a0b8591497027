"""The table of topics against the public contract."""

import pytest

from bdt_msgs_py import topics
from bdt_msgs_py.topics import ALL_TOPICS, Topic

# name: type, reliable, transient local, depth (None where the contract leaves it open)
CONTRACT = {
    "measurement": ("sensor_msgs/msg/JointState", True, False, 10),
    "command": ("sensor_msgs/msg/JointState", True, False, 10),
    "reference": ("sensor_msgs/msg/JointState", True, True, 1),
    "telemetry": ("std_msgs/msg/Float64MultiArray", True, False, 100),
    "truth": ("std_msgs/msg/Float64MultiArray", False, False, None),
    "backlash_estimate": ("sensor_msgs/msg/JointState", True, True, 1),
    "/clock": ("rosgraph_msgs/msg/Clock", False, False, None),
    "/diagnostics": ("diagnostic_msgs/msg/DiagnosticArray", True, False, None),
}


@pytest.mark.parametrize("name", CONTRACT)
def test_a_topic_of_the_contract_has_its_type_and_quality(name):
    [topic] = [topic for topic in ALL_TOPICS if topic.name == name]
    message_type, reliable, transient_local, depth = CONTRACT[name]
    assert topic.message_type == message_type
    assert topic.reliable == reliable
    assert topic.transient_local == transient_local
    assert depth in (None, topic.depth)


def test_every_topic_of_the_module_is_listed_once():
    defined = [value for value in vars(topics).values() if isinstance(value, Topic)]
    assert sorted(topic.name for topic in defined) == sorted(topic.name for topic in ALL_TOPICS)
    assert len({topic.name for topic in ALL_TOPICS}) == len(ALL_TOPICS)


def test_only_names_that_ros_fixes_are_absolute():
    absolute = {topic.name for topic in ALL_TOPICS if topic.name.startswith("/")}
    assert absolute == {"/clock", "/diagnostics", "/parameter_events"}


def test_every_topic_says_what_it_carries():
    assert all(topic.content for topic in ALL_TOPICS)


def test_the_columns_are_those_of_the_contract():
    assert [label.split("[")[0] for label in topics.TELEMETRY_COLUMNS] == ["t", "u", "q3"]
    assert [label.split("[")[0] for label in topics.TRUTH_COLUMNS] == [
        "t",
        "theta_m",
        "theta_d",
        "gap",
        "q1",
        "q2",
        "q3",
    ]


@pytest.mark.parametrize("columns", [topics.TELEMETRY_COLUMNS, topics.TRUTH_COLUMNS])
def test_a_column_label_has_a_unit_and_no_comma(columns):
    """The labels are joined by commas in the layout of a message."""
    for label in columns:
        assert label.endswith("]")
        assert "," not in label
