"""The directives ``topic-table`` and ``parameter-table``: what the code defines, as tables.

    ```{topic-table}
    ```

    ```{parameter-table} plant
    ```

Each row is an anchor: ``parameters.html#plant.mode``.
"""

from collections.abc import Iterable, Sequence
from typing import Any

from docutils import nodes
from python_packages import left_out
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

Cell = Sequence[nodes.Node]


class TopicTable(SphinxDirective):
    """All topics of the project."""

    def run(self) -> list[nodes.Node]:
        """Return the table."""
        try:
            from bdt_msgs_py.topics import ALL_TOPICS  # noqa: PLC0415
        except ImportError as error:
            return left_out(self, error)
        self.env.note_reread()
        rows = (
            (
                topic.name.lstrip("/"),
                (
                    [nodes.literal(text=topic.name)],
                    [nodes.Text(topic.message_type.replace("/msg/", "/"))],
                    [nodes.Text(topic.content)],
                    [nodes.Text(quality_of_service(topic))],
                ),
            )
            for topic in ALL_TOPICS
        )
        return [table(("topic", "type", "content", "QoS"), (16, 24, 40, 20), rows)]


class ParameterTable(SphinxDirective):
    """All parameters of a node."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the table."""
        try:
            from bdt_bringup.installed import parameter_table  # noqa: PLC0415
            from bdt_msgs_py.parameter_tables import known_parameters  # noqa: PLC0415
        except ImportError as error:
            return left_out(self, error)
        self.env.note_reread()
        node = self.arguments[0]
        rows = (
            (
                f"{node}.{name}",
                (
                    [nodes.literal(text=name)],
                    [nodes.literal(text=value_text(default))],
                    [nodes.Text(described.unit)],
                    [nodes.Text(allowed_text(described))],
                    meaning(described),
                ),
            )
            for name, (default, described) in known_parameters(parameter_table(node)).items()
        )
        heads = ("parameter", "default", "unit", "allowed", "meaning")
        return [table(heads, (24, 12, 8, 16, 40), rows)]


def quality_of_service(topic: Any) -> str:
    """Return the quality of service of a topic in the words of ROS."""
    words = ["reliable" if topic.reliable else "best effort"]
    if topic.transient_local:
        words.append("transient local")
    words.append(f"depth {topic.depth}")
    if topic.kept > topic.depth:
        words.append(f"publishers keep {topic.kept}")
    return ", ".join(words)


def allowed_text(described: Any) -> str:
    """Return the allowed values of a quantity; the unit has a column of its own."""
    if described.choices or described.minimum is None or described.maximum is None:
        return str(described.allowed())
    return f"{described.minimum:g} to {described.maximum:g}"


def value_text(default: Any) -> str:
    """Return a value as a parameter file has it."""
    if isinstance(default, bool):
        return str(default).lower()
    if isinstance(default, tuple):
        return "[" + ", ".join(value_text(item) for item in default) + "]"
    if isinstance(default, float):
        return f"{default:g}"
    return f'"{default}"' if default == "" else str(default)


def meaning(described: Any) -> Cell:
    """Return what a quantity means, and whether it may change while the node runs."""
    text = nodes.Text(described.description)
    if not described.reconfigurable:
        return [text]
    return [text, nodes.Text(" "), nodes.emphasis(text="(while the node runs)")]


def table(
    heads: Sequence[str], widths: Sequence[int], rows: Iterable[tuple[str, Sequence[Cell]]]
) -> nodes.table:
    """Return a table whose rows have anchors."""
    group = nodes.tgroup(cols=len(heads))
    group += [nodes.colspec(colwidth=width) for width in widths]
    group += nodes.thead("", row([[nodes.Text(head)] for head in heads]))
    body = nodes.tbody()
    for anchor, cells in rows:
        body += row(cells, anchor)
    group += body
    return nodes.table("", group, classes=["interface"])


def row(cells: Sequence[Cell], anchor: str = "") -> nodes.row:
    """Return a row of a table."""
    entries = [nodes.entry("", nodes.paragraph("", "", *cell)) for cell in cells]
    return nodes.row("", *entries, ids=[anchor] if anchor else [])


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the directives."""
    app.add_directive("topic-table", TopicTable)
    app.add_directive("parameter-table", ParameterTable)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
