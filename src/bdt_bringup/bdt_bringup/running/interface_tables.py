"""Topics and parameters as Markdown tables, derived from the code that defines them.

``python -m bdt_bringup.running.interface_tables`` prints the tables of the README; a test compares.
"""

from typing import Any

from bdt_bringup.running.configuration import NODES, known_parameters
from bdt_bringup.running.recorder_settings import PARAMETERS as RECORDER_PARAMETERS
from bdt_msgs_py.quantities import Quantity, quantities_of
from bdt_msgs_py.topics import ALL_TOPICS, Topic


def topic_table() -> str:
    """Return the table of all topics."""
    rows = [
        f"| `{topic.name}` | {topic.message_type} | {topic.content} | {_quality(topic)} |"
        for topic in ALL_TOPICS
    ]
    return "\n".join(["| topic | type | content | QoS |", "|---|---|---|---|", *rows])


def parameter_table(node: str) -> str:
    """Return the table of a node's parameters.

    Parameters
    ----------
    node : str
        ``plant``, ``controller``, ``twin`` or ``recorder``.
    """
    if node in NODES:
        parameters = known_parameters(node)
    else:
        parameters = {
            name: (default, described)
            for _, kind in RECORDER_PARAMETERS
            for name, default, described in quantities_of(kind)
        }
    rows = [_parameter_row(name, *item) for name, item in parameters.items()]
    head = ["| parameter | default | unit | allowed | meaning |", "|---|---|---|---|---|"]
    return "\n".join([*head, *rows])


def _parameter_row(name: str, default: Any, described: Quantity) -> str:
    live = " (while it runs)" if described.reconfigurable else ""
    return (
        f"| `{name}` | {_value(default)} | {described.unit} | {_allowed(described)} "
        f"| {described.description}{live} |"
    )


def _allowed(described: Quantity) -> str:
    if described.choices or described.minimum is None or described.maximum is None:
        return described.allowed()
    return f"{described.minimum:g} to {described.maximum:g}"


def _value(default: Any) -> str:
    if isinstance(default, bool):
        return str(default).lower()
    if isinstance(default, tuple):
        return "[" + ", ".join(_value(item) for item in default) + "]"
    if isinstance(default, float):
        return f"{default:g}"
    return f'"{default}"' if default == "" else str(default)


def _quality(topic: Topic) -> str:
    words = ["reliable" if topic.reliable else "best effort"]
    if topic.transient_local:
        words.append("transient local")
    return ", ".join([*words, f"depth {topic.depth}"])


def all_tables() -> str:
    """Return all tables with their headings, as they stand in the README."""
    parts = ["### Topics", topic_table()]
    for node in (*NODES, "recorder"):
        parts += [f"### Parameters of `{node}`", parameter_table(node)]
    return "\n\n".join(parts)


if __name__ == "__main__":
    print(all_tables())
