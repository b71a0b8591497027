"""``ros2 service``."""

from ros2cli.commands.options import DISCOVERY
from ros2cli.grammar import Command, Verb, flag, option, word
from ros2cli.number_types import FREQUENCY

__all__ = ["SERVICE_COMMAND"]

_NAME = word("service_name", "such as /controller/get_parameters")
_TYPE = word("service_type", "such as std_srvs/srv/SetBool")
_WHICH = (
    flag("-c", "--count-services", about="print how many there are, not their names"),
    flag("--include-hidden-services", about="also names with a part that begins with _"),
    *DISCOVERY,
)

SERVICE_COMMAND = Command(
    "service",
    "See which services there are, and call them.",
    (
        Verb(
            "call",
            "Send a request, wait for the response and print both.",
            "service_call:call",
            (
                _NAME,
                _TYPE,
                word("values", "the request in YAML: '{data: true}'", nargs="?", default="{}"),
                option(
                    "-r", "--rate", metavar="HZ", type=FREQUENCY, about="go on calling this often"
                ),
            ),
        ),
        Verb("find", "List the services of a type.", "services:show_of_type", (_TYPE, *_WHICH)),
        Verb(
            "info",
            "Print a service's type and how many clients and servers it has.",
            "services:show_information",
            (_NAME, *DISCOVERY),
        ),
        Verb(
            "list",
            "List the services.",
            "services:show_services",
            (flag("-t", "--show-types", about="print their types, too"), *_WHICH),
        ),
        Verb("type", "Print the type of a service.", "services:show_type", (_NAME, *DISCOVERY)),
    ),
)
