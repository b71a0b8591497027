"""``ros2 bag``."""

from ros2cli.commands.options import BAG, BAG_STORAGES
from ros2cli.grammar import Command, Verb, flag, option, word
from ros2cli.number_types import COUNT, FACTOR, FREQUENCY, POSITIVE_COUNT, SECONDS, SECONDS_OR_ALL

__all__ = ["BAG_COMMAND"]

_NO_KEYS = flag("--disable-keyboard-controls", about="no effect: no key does anything")

_INFO = Verb(
    "info",
    "Print what a bag holds and from when it is.",
    "bag_info:info",
    (*BAG, flag("-t", "--topic-name", about="names of the topics alone")),
)

_PLAY = Verb(
    "play",
    "Publish the messages of a bag, each at its time.",
    "bag_play:play",
    (
        *BAG,
        option(
            "-r",
            "--rate",
            metavar="FACTOR",
            type=FACTOR,
            default=1.0,
            about="times as fast as recorded (default: %(default)g)",
        ),
        option("--topics", metavar="TOPIC", nargs="+", default=[], about="these topics"),
        option(
            "--exclude-topics", metavar="TOPIC", nargs="+", default=[], about="all but these topics"
        ),
        option("-e", "--regex", default="", about="topics whose name has a match"),
        option("-x", "--exclude-regex", default="", about="no topic whose name has a match"),
        flag("-l", "--loop", about="begin again at the end"),
        option(
            "-m",
            "--remap",
            metavar="OLD:=NEW",
            nargs="+",
            default=[],
            about="publish under other names",
        ),
        option(
            "--clock",
            metavar="HZ",
            type=FREQUENCY,
            nargs="?",
            const=40.0,
            about="tell the bag's time on /clock this often (%(const)g Hz), not what was recorded",
        ),
        option(
            "-d",
            "--delay",
            metavar="SECONDS",
            type=SECONDS,
            default=0.0,
            about="wait before the beginning, and before each repetition",
        ),
        option(
            "--start-offset",
            metavar="SECONDS",
            type=SECONDS,
            default=0.0,
            about="leave out this much of the beginning",
        ),
        option(
            "--playback-duration",
            metavar="SECONDS",
            type=SECONDS_OR_ALL,
            default=-1.0,
            about="seconds of the bag to play; below 0 all of it (default: all)",
        ),
        option(
            "--wait-for-all-acked",
            metavar="MS",
            type=COUNT,
            about="end when reliable subscriptions have everything, or after MS (0: never give up)",
        ),
        _NO_KEYS,
    ),
)

_RECORD = Verb(
    "record",
    "Write messages into a bag until Ctrl-C.",
    "bag_record:record",
    (
        option("-o", "--output", metavar="FOLDER", about="new folder (default: named by the date)"),
        option(
            "-s",
            "--storage",
            choices=BAG_STORAGES,
            default="mcap",
            about="format of the file (default: %(default)s)",
        ),
        word("topics_positional", "these topics", metavar="TOPIC", nargs="*"),
        option(
            "--topics", metavar="TOPIC", nargs="+", default=[], about="the same, with an option"
        ),
        option(
            "--topic-types", metavar="TYPE", nargs="+", default=[], about="topics of these types"
        ),
        flag("-a", "--all", "--all-topics", about="every topic, now and later"),
        option("-e", "--regex", default="", about="topics whose name has a match"),
        option("--exclude-regex", default="", about="no topic whose name has a match"),
        option(
            "--exclude-topics", metavar="TOPIC", nargs="+", default=[], about="none of these topics"
        ),
        flag("--include-unpublished-topics", about="also topics that are only listened to"),
        flag("--include-hidden-topics", about="also names with a part that begins with _"),
        flag("--no-discovery", about="topics that are there at the beginning, no later ones"),
        option(
            "-p",
            "--polling-interval",
            metavar="MS",
            type=POSITIVE_COUNT,
            default=100,
            about="time between two looks for topics (default: %(default)s ms)",
        ),
        flag("--use-sim-time", about="stamp messages by /clock; nothing is written before it runs"),
        option(
            "--node-name",
            metavar="NAME",
            default="rosbag2_recorder",
            about="name of the recording node (default: %(default)s)",
        ),
        option(
            "--custom-data",
            metavar="KEY=VALUE",
            nargs="*",
            default=[],
            about="notes for metadata.yaml",
        ),
        _NO_KEYS,
    ),
)

BAG_COMMAND = Command("bag", "Record, inspect and play bags.", (_INFO, _PLAY, _RECORD))
