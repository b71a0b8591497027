"""What nodes do about stray messages, as a table of the documentation."""

from pathlib import Path

from stray_messages import Stray

FOLDER = Path(__file__).parents[2] / "docs" / "source" / "reference"
TABLE_DATA = FOLDER / "stray_messages.json"
TABLE = FOLDER / "stray_messages.md"

INTRODUCTION = """# Stray messages

What each node does about a message that does not belong, sent into a running loop by somebody
else: every topic, every field, every fault. The table is made of what
`tests/test_stray_messages.py` finds (`make stray-messages` writes it anew). In all cases no node
ends, voltage and position stay within `limits.voltage` and `limits.position`, and `/diagnostics`
say what was rejected. A loop in lockstep goes on as if nothing had come, bit for bit; two
messages are exceptions, since nobody could tell them from what they pretend to be: a command in
the name of the controller that answers the newest measurement drives the motor for one control
period, within the limits, and a second source of references is obeyed.

*not subscribed*: the node does not take the topic. *accepted*: nothing is wrong that the node could
know, or nothing follows from it. *rejected*: counted by topic and reason in
`rejected_messages_by_reason` of `/diagnostics`:

| reason | a message is rejected because of |
|---|---|
| `layout` | wrong joint names, lengths, labels or sizes |
| `stamp` | a stamp that is no time: negative, or with a second and more of nanoseconds |
| `not_finite` | NaN or an infinite number |
| `range` | a number that no machine has, or beyond the travel |
| `time` | a time that nobody awaits: far from the newest, or not that of a question |
| `change` | a reading that the platform cannot have reached since the one before |
| `samples` | samples with a hole, or at another rate |
| `repeated` | another answer to what was answered, or another reading of the same time |
| `source` | another source than the one that is obeyed |
"""


def table_row(stray: Stray, reactions: dict[str, str]) -> dict[str, str]:
    """Return what is kept of a stray and of what each node did about it."""
    return {"topic": stray.topic.name, "field": stray.field, "fault": stray.fault, **reactions}


def markdown_table(found: list[dict[str, str]]) -> str:
    """Return the page for a list of rows: topic, field, fault and a cell for each node."""
    columns = list(found[0])
    lines = [INTRODUCTION, _line(columns), "|" + "---|" * len(columns)]
    lines += [_line([_code(row, column) for column in columns]) for row in found]
    return "\n".join(lines) + "\n"


def _code(row: dict[str, str], column: str) -> str:
    is_name = column in {"topic", "field"} and row[column] != "all"
    return f"`{row[column]}`" if is_name else row[column]


def _line(cells: list[str]) -> str:
    return "| " + " | ".join(cells) + " |"
