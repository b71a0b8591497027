"""Which topic of a bag is which of the project's."""

import pytest

from bdt_bags.bag_error import BagError
from bdt_bags.reading.topic_selection import (
    CONTENTS,
    RecordedTopic,
    TopicSelection,
    select_topics,
    topic_remapping,
)
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    COMMAND,
    MEASUREMENT,
    PARAMETER_EVENTS,
    REFERENCE,
    TELEMETRY,
    TRUTH,
)

LOOP = (TELEMETRY, MEASUREMENT, COMMAND, REFERENCE, BACKLASH_ESTIMATE, TRUTH, PARAMETER_EVENTS)


def names(namespace: str = "", **remapped: str) -> dict[RecordedTopic, str]:
    """Return the topics of a loop with their contents."""
    found = {}
    for topic in LOOP:
        name = topic.name if topic.name.startswith("/") else f"{namespace}/{topic.name}"
        name = remapped.get(topic.name, name)
        found[RecordedTopic(name, topic.message_type)] = CONTENTS.get(topic, "")
    return found


def select(recorded: dict[RecordedTopic, str], namespace=None, **chosen: str) -> dict[str, str]:
    found = select_topics(list(recorded), TopicSelection(namespace, chosen), recorded.get)
    return {topic.name: recorded.name for topic, recorded in found.items()}


@pytest.mark.parametrize("namespace", ["", "/a", "/lab/rig_1"])
def test_one_loop_is_found_in_any_namespace(namespace):
    found = select(names(namespace))
    assert found["telemetry"] == f"{namespace}/telemetry"
    assert found["/parameter_events"] == "/parameter_events"
    assert len(found) == len(LOOP)


def test_two_loops_need_a_choice():
    both = names("/a") | names("/b")
    with pytest.raises(BagError, match="holds 2 loops, in the namespaces /a and /b: choose one"):
        select(both)
    for namespace in ("/b", "b", "b/"):
        assert set(select(both, namespace).values()) == {x.name for x in names("/b")}
    with pytest.raises(BagError, match="has no loop in namespace /c: must be /a or /b"):
        select(both, "c")
    with pytest.raises(BagError, match="has no loop in namespace /: must be /a or /b"):
        select(both, "/")


def test_chosen_loop_does_not_borrow_from_the_other():
    both = names("/a") | names("/b")
    del both[RecordedTopic("/a/reference", REFERENCE.message_type)]
    assert "reference" not in select(both, "/a")


def test_loops_without_telemetry():
    both = names("/a") | names("/b")
    for namespace in ("/a", "/b"):
        del both[RecordedTopic(f"{namespace}/telemetry", TELEMETRY.message_type)]
    with pytest.raises(BagError, match="holds 2 loops"):
        select(both)
    assert select(both, "b")["measurement"] == "/b/measurement"


@pytest.mark.parametrize("topic", [x for x in LOOP if x in CONTENTS])
def test_one_remapped_topic_is_found_by_content(topic):
    recorded = names(**{topic.name: "/lab/something"})
    assert select(recorded)[topic.name] == "/lab/something"


def test_content_that_two_could_have_is_not_guessed():
    both = names(measurement="/x", reference="/y")
    found = select(both)
    assert "measurement" not in found
    assert "reference" not in found
    chosen = select(both, measurement="/x")
    assert (chosen["measurement"], chosen["reference"]) == ("/x", "/y")
    del both[RecordedTopic("/y", REFERENCE.message_type)]
    assert not {"measurement", "reference"} & set(select(both))
    twins = names(truth="/x") | {RecordedTopic("/y", TRUTH.message_type): CONTENTS[TRUTH]}
    assert "truth" not in select(twins)


def test_chosen_topics():
    recorded = names() | names("/b", telemetry="/b/samples")
    assert select(recorded, telemetry="/b/samples")["telemetry"] == "/b/samples"
    with pytest.raises(BagError, match=r"lacks topic /none \(std_msgs/msg/Float64MultiArray\)"):
        select(recorded, telemetry="/none")
    with pytest.raises(BagError, match="topic /command has type sensor_msgs/msg/JointState: must"):
        select(recorded, telemetry="/command")
    with pytest.raises(BagError, match="topic 'clock': must be one of telemetry, measurement"):
        TopicSelection(names={"clock": "/clock"})


def test_choice_between_two_of_one_name():
    recorded = names() | {RecordedTopic("/x/truth", TRUTH.message_type): ""}
    del recorded[RecordedTopic("/truth", TRUTH.message_type)]
    assert select(recorded)["truth"] == "/x/truth"
    recorded[RecordedTopic("/y/truth", TRUTH.message_type)] = ""
    with pytest.raises(BagError, match="/x/truth and /y/truth could both be the topic truth"):
        select(recorded)
    assert select(recorded, truth="/y/truth")["truth"] == "/y/truth"


def test_nothing_to_analyze():
    with pytest.raises(BagError, match=r"lacks topic telemetry .* it has no topics"):
        select({})
    with pytest.raises(BagError, match="if /arm is it, say --topic measurement=/arm"):
        select({RecordedTopic("/arm", MEASUREMENT.message_type): "elbow"})
    with pytest.raises(BagError, match="it has /truth"):
        select({RecordedTopic("/truth", TRUTH.message_type): CONTENTS[TRUTH]})


@pytest.mark.parametrize("text", ["telemetry=/my/x", "telemetry:=/my/x", "telemetry=my/x"])
def test_remapping(text):
    assert topic_remapping(text) == ("telemetry", "/my/x")


@pytest.mark.parametrize("text", ["telemetry", "=/x", "telemetry=", ""])
def test_remapping_that_is_none(text):
    with pytest.raises(BagError, match="must be TOPIC=NAME"):
        topic_remapping(text)
