"""Which topic of a bag is which of the project's: by name, by choice, or by content."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from bdt_bags.bag_error import BagError
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    COMMAND,
    DIAGNOSTICS,
    GAP_JOINT,
    JOINT_STATE,
    MARK,
    MEASUREMENT,
    MOTOR_JOINT,
    PARAMETER_EVENTS,
    PLATFORM_JOINT,
    REFERENCE,
    SAMPLES,
    TELEMETRY,
    TELEMETRY_COLUMNS,
    TRUTH,
    TRUTH_COLUMNS,
    Topic,
)

TOPICS = {
    topic.name.rpartition("/")[2]: topic
    for topic in (
        TELEMETRY,
        MEASUREMENT,
        COMMAND,
        REFERENCE,
        BACKLASH_ESTIMATE,
        TRUTH,
        PARAMETER_EVENTS,
        DIAGNOSTICS,
        MARK,
    )
}
"""What the analysis reads, by the last component of its name."""

CONTENTS = {
    TELEMETRY: ",".join(TELEMETRY_COLUMNS),
    TRUTH: ",".join(TRUTH_COLUMNS),
    MEASUREMENT: PLATFORM_JOINT,
    REFERENCE: PLATFORM_JOINT,
    COMMAND: MOTOR_JOINT,
    BACKLASH_ESTIMATE: GAP_JOINT,
}
"""Column labels or joint by which the messages of a topic can be told."""


@dataclass(frozen=True)
class TopicSelection:
    """What the user says about the topics of a bag.

    Attributes
    ----------
    namespace : str or None
        Namespace of the loop, with or without the first slash; None when there is only one loop.
    names : mapping of str to str
        Name in the bag of some of :data:`TOPICS`, for topics that were remapped.
    """

    namespace: str | None = None
    names: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in self.names:
            if name not in TOPICS:
                raise BagError(f"topic {name!r}: must be one of {', '.join(TOPICS)}")


class RecordedTopic(NamedTuple):
    """A topic of a bag: name and ROS type."""

    name: str
    message_type: str


def topic_remapping(text: str) -> tuple[str, str]:
    """Return the two names of ``telemetry:=/my/telemetry`` or ``telemetry=/my/telemetry``.

    Raises
    ------
    BagError
        If it is none.
    """
    name, separator, recorded = text.replace(":=", "=", 1).partition("=")
    if not separator or not name or not recorded:
        raise BagError(f"topic {text!r}: must be TOPIC=NAME, as in telemetry=/my/telemetry")
    return name, absolute(recorded)


def absolute(name: str) -> str:
    """Return a name with its first slash and without a last one; empty for the root."""
    stripped = name.strip("/")
    return f"/{stripped}" if stripped else ""


def select_topics(
    recorded: Collection[RecordedTopic],
    selection: TopicSelection,
    content: Callable[[RecordedTopic], str | None],
) -> dict[Topic, RecordedTopic]:
    """Return which recorded topic is which of the project's.

    A topic that the user names is taken. Others are found by the last component of their name and
    their type; the namespace is that of the telemetry, or of the measurements where there is no
    telemetry. What is then still missing is found by what its messages hold, if only one topic
    and only one missing name agree.

    Parameters
    ----------
    recorded : collection of RecordedTopic
        All topics of the bag.
    selection : TopicSelection
        What the user says.
    content : callable
        Returns the column labels or the joint of the first message of a topic, None without one.

    Returns
    -------
    dict of Topic to RecordedTopic
        Topics that are not there are left out; telemetry or measurement always is.

    Raises
    ------
    BagError
        If there is neither telemetry nor measurement, if a topic has the wrong type, or if
        several topics or loops could be meant.
    """
    found = {TOPICS[name]: _named(recorded, name, x) for name, x in selection.names.items()}
    namespace = _namespace(recorded, selection, found)
    for component, topic in TOPICS.items():
        if topic not in found:
            candidates = _candidates(recorded, component, topic, namespace)
            if selection.namespace is not None and not topic.name.startswith("/"):
                candidates = [x for x in candidates if _split(x.name)[0] == namespace]
            if len(candidates) > 1:
                raise BagError(
                    f"{' and '.join(x.name for x in candidates)} could both be the topic "
                    f"{component}: choose with --topic {component}=NAME"
                )
            found.update((topic, candidate) for candidate in candidates)
    _add_by_content(found, recorded, content)
    if TELEMETRY not in found and MEASUREMENT not in found:
        raise BagError(_nothing_found(recorded))
    return found


def _named(recorded: Collection[RecordedTopic], component: str, name: str) -> RecordedTopic:
    types = [x for x in recorded if x.name == name]
    for topic in types:
        if topic.message_type == TOPICS[component].message_type:
            return topic
    required = TOPICS[component].message_type
    if types:
        raise BagError(f"topic {name} has type {types[0].message_type}: must be {required}")
    raise BagError(f"lacks topic {name} ({required}){_it_has(recorded)}")


def _namespace(
    recorded: Collection[RecordedTopic],
    selection: TopicSelection,
    found: Mapping[Topic, RecordedTopic],
) -> str:
    """Return the namespace of the loop."""
    loops: list[str] = []
    for topic in (TELEMETRY, MEASUREMENT):
        loops = loops or sorted(
            _split(x.name)[0]
            for x in recorded
            if _split(x.name)[1] == topic.name and x.message_type == topic.message_type
        )
    if selection.namespace is not None:
        namespace = absolute(selection.namespace)
        # Telemetry may be elsewhere; then any topic of a loop shows where the others are.
        if all(_split(x.name)[0] != namespace for x in recorded if _is_of_loop(x)):
            raise BagError(
                f"has no loop in namespace {namespace or '/'}: "
                f"must be {' or '.join(x or '/' for x in loops) or 'one that it has'}"
            )
        return namespace
    for topic in (TELEMETRY, MEASUREMENT):
        if topic in found:
            return _split(found[topic].name)[0]
    if len(loops) > 1:
        raise BagError(
            f"holds {len(loops)} loops, in the namespaces {' and '.join(x or '/' for x in loops)}: "
            "choose one with --namespace NAME"
        )
    return loops[0] if loops else ""


def _is_of_loop(recorded: RecordedTopic) -> bool:
    topic = TOPICS.get(_split(recorded.name)[1])
    return topic in CONTENTS and recorded.message_type == topic.message_type


def _candidates(
    recorded: Collection[RecordedTopic], component: str, topic: Topic, namespace: str
) -> list[RecordedTopic]:
    """Return the topics of that name and type, the nearest to the loop if there are several."""
    named = [x for x in recorded if _split(x.name)[1] == component]
    typed = sorted({x for x in named if x.message_type == topic.message_type})
    if named and not typed and topic in {TELEMETRY, MEASUREMENT}:
        wrong = min(named)
        raise BagError(
            f"topic {wrong.name} has type {wrong.message_type}: must be {topic.message_type}"
        )
    for nearest in (topic.name, f"{namespace}/{component}"):
        if any(x.name == nearest for x in typed):
            return [x for x in typed if x.name == nearest]
    return typed


def _add_by_content(
    found: dict[Topic, RecordedTopic],
    recorded: Collection[RecordedTopic],
    content: Callable[[RecordedTopic], str | None],
) -> None:
    """Add topics that were remapped and can be told by what they hold."""
    missing = [topic for topic in CONTENTS if topic not in found]
    unknown = [
        x
        for x in recorded
        if x.message_type in {SAMPLES, JOINT_STATE}
        and x not in found.values()
        and _split(x.name)[1] not in TOPICS
    ]
    contents = {x: content(x) for x in unknown} if missing else {}
    for topic in missing:
        alike = [x for x in unknown if contents[x] == CONTENTS[topic]]
        wanted = [x for x in missing if CONTENTS[x] == CONTENTS[topic]]
        if len(alike) == len(wanted) == 1:
            found[topic] = alike[0]


def _nothing_found(recorded: Collection[RecordedTopic]) -> str:
    for topic in (TELEMETRY, MEASUREMENT):
        alike = sorted(
            x.name
            for x in recorded
            if x.message_type == topic.message_type and _split(x.name)[1] not in TOPICS
        )
        if alike:
            return (
                f"lacks topic {TELEMETRY.name} or {MEASUREMENT.name}; if {alike[0]} is it, say "
                f"--topic {topic.name}={alike[0]}"
            )
    return (
        f"lacks topic {TELEMETRY.name} ({TELEMETRY.message_type}) "
        f"or {MEASUREMENT.name} ({MEASUREMENT.message_type}){_it_has(recorded)}"
    )


def _it_has(recorded: Collection[RecordedTopic]) -> str:
    return "; it has " + (", ".join(sorted({x.name for x in recorded})[:20]) or "no topics")


def _split(name: str) -> tuple[str, str]:
    namespace, _, component = name.rpartition("/")
    return namespace, component
