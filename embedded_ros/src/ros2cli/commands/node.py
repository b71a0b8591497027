"""``ros2 node``."""

from ros2cli.commands.options import DISCOVERY
from ros2cli.grammar import Command, Verb, flag, word

__all__ = ["NODE_COMMAND"]

NODE_COMMAND = Command(
    "node",
    "See which nodes run and what they talk about.",
    (
        Verb(
            "info",
            "List the topics and services of a node.",
            "nodes:show_node",
            (
                word("node_name", "such as /controller"),
                flag("--include-hidden", about="also names with a part that begins with _"),
                *DISCOVERY,
            ),
        ),
        Verb(
            "list",
            "List the nodes that run.",
            "nodes:show_nodes",
            (
                flag("-a", "--all", about="also hidden nodes, whose names begin with _"),
                flag("-c", "--count-nodes", about="print how many there are, not their names"),
                *DISCOVERY,
            ),
        ),
    ),
)
