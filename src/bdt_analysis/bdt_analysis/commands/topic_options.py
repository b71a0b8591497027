"""Options of ``bdt analyze`` and ``bdt compare`` about the loop and the topics of a bag."""

import argparse

from bdt_bags.reading.topic_selection import TopicSelection, topic_remapping


def add_topic_options(command: argparse.ArgumentParser) -> None:
    """Add the options; :func:`topic_selection` reads and checks them."""
    command.add_argument(
        "--namespace", metavar="NAME", help="namespace of the loop, for a bag that holds several"
    )
    command.add_argument(
        "--topic",
        action="append",
        default=[],
        metavar="TOPIC=NAME",
        help="a topic that was remapped: telemetry=/my/telemetry (repeatable)",
    )


def topic_selection(options: argparse.Namespace) -> TopicSelection:
    """Return what the options say.

    Parameters
    ----------
    options : argparse.Namespace
        Parsed options.

    Raises
    ------
    BagError
        If a topic is not TOPIC=NAME or none that the analysis reads.
    """
    return TopicSelection(options.namespace, dict(map(topic_remapping, options.topic)))
