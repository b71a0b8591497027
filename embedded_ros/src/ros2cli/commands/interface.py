"""``ros2 interface``."""

from ros2cli.grammar import Argument, Command, OneOf, Verb, flag, option, word

__all__ = ["INTERFACE_COMMAND"]


def _only(kind: str, what: str) -> Argument:
    return option(
        f"-{kind[0]}",
        f"--only-{kind}s",
        action="append_const",
        dest="kinds",
        const=kind,
        about=f"those of {what}; can be combined",
    )


_KINDS = (_only("msg", "messages"), _only("srv", "services"), _only("action", "actions"))

INTERFACE_COMMAND = Command(
    "interface",
    "Look up what messages and services consist of.",
    (
        Verb("list", "List the types that are installed.", "interfaces:show_types", _KINDS),
        Verb(
            "package",
            "List the types of a package.",
            "interfaces:show_types_of_package",
            (word("package_name", "such as sensor_msgs"),),
        ),
        Verb("packages", "List the packages that have types.", "interfaces:show_packages", _KINDS),
        Verb(
            "show",
            "Print the fields of a type, nested ones indented.",
            "interfaces:show_definition",
            (
                word("type", "such as std_msgs/msg/String, or - to read it from standard input"),
                OneOf(
                    (
                        flag("--all-comments", about="also the comments of nested types"),
                        flag("--no-comments", about="fields and constants alone"),
                    )
                ),
            ),
        ),
    ),
)
