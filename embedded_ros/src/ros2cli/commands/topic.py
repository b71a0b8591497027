"""``ros2 topic``."""

from ros2cli.commands.options import DISCOVERY, SIMULATED_TIME, quality_of_service
from ros2cli.grammar import Command, OneOf, Verb, flag, option, word
from ros2cli.number_types import COUNT, FREQUENCY, POSITIVE_COUNT, POSITIVE_SECONDS, SECONDS

__all__ = ["TOPIC_COMMAND"]

_NAME = word("topic_name", "such as /measurement")
_WHICH = (
    flag("-c", "--count-topics", about="print how many there are, not their names"),
    flag("--include-hidden-topics", about="also names with a part that begins with _"),
    *DISCOVERY,
)

_ECHO = Verb(
    "echo",
    "Print messages as they arrive.",
    "topic_echo:echo",
    (
        _NAME,
        word("message_type", "asked from who uses the topic, unless given", nargs="?"),
        flag("--once", about="end after one message"),
        option(
            "--timeout", metavar="SECONDS", type=SECONDS, about="end after this time, come what may"
        ),
        flag("--csv", about="one line a message, values separated by commas"),
        option("--field", metavar="A.B", about="a part of each message, such as header.stamp"),
        option(
            "--filter",
            metavar="EXPRESSION",
            about="messages m for which this Python is true, such as 'm.data > 1'",
        ),
        flag("--raw", about="the bytes that were received, not decoded"),
        flag("-f", "--full-length", about="long arrays and texts in full"),
        option(
            "-l",
            "--truncate-length",
            metavar="N",
            type=COUNT,
            default=128,
            about="elements or characters after which ... stands (default: %(default)s)",
        ),
        flag("--no-arr", about="type and length of arrays, not what they hold"),
        flag("--no-str", about="the length of texts, not what they say"),
        flag("--flow-style", about="arrays in one line: [1.0, 2.0]"),
        flag("-i", "--include-message-info", about="when each was sent and received"),
        *quality_of_service("sensor_data"),
        *DISCOVERY,
    ),
)

_HZ = Verb(
    "hz",
    "Measure how often messages arrive.",
    "topic_hz:hz",
    (
        _NAME,
        option(
            "-w",
            "--window",
            metavar="N",
            type=POSITIVE_COUNT,
            default=10000,
            about="mean over this many messages at most (default: %(default)s)",
        ),
        flag("--wall-time", about="by the computer's time even if /clock is used"),
        SIMULATED_TIME,
        *DISCOVERY,
    ),
)

_PUB = Verb(
    "pub",
    "Publish a message, again and again unless told otherwise.",
    "topic_pub:pub",
    (
        _NAME,
        word("message_type", "such as std_msgs/msg/Float64"),
        word("values", "the message in YAML: '{data: 1.5}'", nargs="?", default="{}"),
        option(
            "-r",
            "--rate",
            metavar="HZ",
            type=FREQUENCY,
            default=1.0,
            about="how often (default: %(default)g Hz)",
        ),
        option(
            "-p",
            "--print",
            metavar="N",
            type=COUNT,
            default=1,
            about="print one message in N, none with 0 (default: %(default)s)",
        ),
        OneOf(
            (
                flag("-1", "--once", about="end after one message"),
                option(
                    "-t",
                    "--times",
                    metavar="N",
                    type=COUNT,
                    default=0,
                    about="end after N messages",
                ),
            )
        ),
        option(
            "-w",
            "--wait-matching-subscriptions",
            metavar="N",
            type=COUNT,
            about="begin when so many listen (default: 1 if the number of messages is limited)",
        ),
        option(
            "--max-wait-time-secs",
            metavar="SECONDS",
            type=POSITIVE_SECONDS,
            about="give up waiting for them after this time",
        ),
        option(
            "--keep-alive",
            metavar="SECONDS",
            type=SECONDS,
            default=0.1,
            about="stay so long after the last message, for it to arrive (default: %(default)g s)",
        ),
        option("-n", "--node-name", metavar="NAME", about="publish under this node's name"),
        SIMULATED_TIME,
        *quality_of_service("default"),
    ),
)

TOPIC_COMMAND = Command(
    "topic",
    "See which topics there are, listen and publish.",
    (
        _ECHO,
        Verb(
            "find",
            "List the topics of a type.",
            "topics:show_of_type",
            (word("topic_type", "such as sensor_msgs/msg/JointState"), *_WHICH),
        ),
        _HZ,
        Verb(
            "info",
            "Print a topic's type and how many publish and listen.",
            "topics:show_information",
            (_NAME, flag("-v", "--verbose", about="who they are, and with which QoS"), *DISCOVERY),
        ),
        Verb(
            "list",
            "List the topics.",
            "topics:show_topics",
            (
                flag("-t", "--show-types", about="print their types, too"),
                flag("-v", "--verbose", about="print types, and how many publish and listen"),
                *_WHICH,
            ),
        ),
        _PUB,
        Verb("type", "Print the type of a topic.", "topics:show_type", (_NAME, *DISCOVERY)),
    ),
)
