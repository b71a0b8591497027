"""``ros2 param``."""

from ros2cli.commands.options import DISCOVERY
from ros2cli.grammar import Command, Verb, flag, option, word
from ros2cli.number_types import SECONDS

__all__ = ["PARAM_COMMAND"]

_NODE = word("node_name", "such as /controller")
_NAME = word("parameter_name", "with dots if it is nested: pid.integral")
_WAITING = (
    option(
        "--timeout",
        metavar="SECONDS",
        type=SECONDS,
        default=1.0,
        about="how long the node may take to appear (default: %(default)g s)",
    ),
    *DISCOVERY,
)

PARAM_COMMAND = Command(
    "param",
    "Read and change the parameters of nodes that run.",
    (
        Verb(
            "delete",
            "Take a parameter away from a node that allows it.",
            "param_changes:delete",
            (_NODE, _NAME, *_WAITING),
        ),
        Verb(
            "describe",
            "Tell type, meaning and limits of parameters.",
            "params:describe",
            (_NODE, word("parameter_names", "one or more", nargs="+"), *_WAITING),
        ),
        Verb(
            "dump",
            "Print a node's parameters as a file that `param load` and --params-file read.",
            "params:dump",
            (_NODE, *_WAITING),
        ),
        Verb(
            "get",
            "Print the value of a parameter.",
            "params:get",
            (_NODE, _NAME, flag("--hide-type", about="print the bare value"), *_WAITING),
        ),
        Verb(
            "list",
            "List the parameters of a node, or of all.",
            "params:show_names",
            (
                word("node_name", "such as /controller; all nodes without it", nargs="?"),
                option("--filter", metavar="REGEX", about="names that begin with a match"),
                option(
                    "--param-prefixes",
                    metavar="PREFIX",
                    nargs="+",
                    default=[],
                    about="names below these: pid for pid.integral",
                ),
                flag("--param-type", about="print their types, too"),
                *_WAITING,
            ),
        ),
        Verb(
            "load",
            "Set a node's parameters to those of a YAML file.",
            "param_changes:load",
            (
                _NODE,
                word("parameter_file", "as `param dump` prints it"),
                flag("--no-use-wildcard", about="without what the file has for all nodes, '/**'"),
                *_WAITING,
            ),
        ),
        Verb(
            "set",
            "Change a parameter; the node may refuse.",
            "param_changes:set_value",
            (
                _NODE,
                _NAME,
                word("value", "in YAML, which tells its type: 1.0 is a double, 1 an integer"),
                *_WAITING,
            ),
        ),
    ),
)
