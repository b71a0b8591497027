"""The directive ``command-reference``: every command and option, from the argparse parsers.

It stands in a reStructuredText page and makes ``program`` and ``option`` of Sphinx's own, so that
any page can link to an option: {option}`--duration <bdt run --duration>`.
"""

import argparse
import re
from collections.abc import Iterator
from functools import partial

from docutils import nodes
from docutils.statemachine import StringList
from python_packages import left_out
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

USAGE_WIDTH = 90
"""Characters of a line that fit on a page; argparse would take the width of a terminal."""


class CommandReference(SphinxDirective):
    """The subcommands of ``bdt``, each with its options."""

    def run(self) -> list[nodes.Node]:
        """Return a section for each subcommand."""
        try:
            from bdt_bringup.cli import command_parser  # noqa: PLC0415
            from bdt_bringup.installed import installed_commands  # noqa: PLC0415
        except ImportError as error:
            return left_out(self, error)
        self.env.note_reread()
        bdt = command_parser(installed_commands())
        lines = [line for name, parser in subcommands(bdt) for line in command(name, parser)]
        container = nodes.Element()
        container.document = self.state.document
        self.state.nested_parse(
            StringList(lines, "command-reference"), 0, container, match_titles=True
        )
        return container.children


def subcommands(parser: argparse.ArgumentParser) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    """Iterate over name and parser of the subcommands of a parser."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, subparser in action.choices.items():
                yield f"{parser.prog} {name}", subparser


def command(name: str, parser: argparse.ArgumentParser) -> Iterator[str]:
    """Iterate over the lines of the section about a command."""
    parser.formatter_class = partial(argparse.HelpFormatter, width=USAGE_WIDTH)
    usage = parser.format_usage().splitlines()
    yield from (name, "-" * len(name), "", *wrapped(parser.description), "")
    yield from (".. code-block:: text", "", *(f"   {line}" for line in usage), "")
    yield from (f".. program:: {name}", "")
    for action in parser._actions:
        if not isinstance(action, argparse._HelpAction):
            yield from (f".. option:: {invocation(action)}", "", *wrapped(help_text(action), 3), "")


def invocation(action: argparse.Action) -> str:
    """Return an option with its value, or the name of a positional argument."""
    value = action.metavar or (
        "{" + ",".join(str(choice) for choice in action.choices) + "}" if action.choices else ""
    )
    if not action.option_strings:
        return str(value or action.dest)
    shown = str(value) if action.nargs != 0 else ""
    return ", ".join(f"{option} {shown}".rstrip() for option in action.option_strings)


def help_text(action: argparse.Action) -> str:
    """Return the help of an option as argparse would print it."""
    text = (action.help or "") % {**vars(action), "prog": ""}
    return text[:1].upper() + text[1:] + "."


def wrapped(text: str | None, indent: int = 0) -> list[str]:
    """Return a text in which reStructuredText finds no markup."""
    return [" " * indent + re.sub(r"([\\*`|_])", r"\\\1", text or "")]


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the directive."""
    app.add_directive("command-reference", CommandReference)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
