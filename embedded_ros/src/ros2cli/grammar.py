"""What can be typed, as data: commands, their verbs and the arguments of those.

The tables in :mod:`ros2cli.commands` are made of these. Only what is called is imported, so
that help costs no more than argparse.
"""

import argparse
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NoReturn

__all__ = ["Argument", "Command", "OneOf", "Verb", "build_parser", "flag", "option", "word"]


@dataclass(frozen=True)
class Argument:
    """A word or an option.

    Attributes
    ----------
    names : tuple of str
    settings : tuple of (str, object)
        Further keywords of :meth:`argparse.ArgumentParser.add_argument`.
    """

    names: tuple[str, ...]
    settings: tuple[tuple[str, Any], ...]

    def add_to(self, parser: Any) -> None:
        """Make it known to a parser, or to a group of one."""
        parser.add_argument(*self.names, **dict(self.settings))


@dataclass(frozen=True)
class OneOf:
    """Options of which one can be given at a time."""

    options: tuple[Argument, ...]

    def add_to(self, parser: Any) -> None:
        """Make them known to a parser."""
        group = parser.add_mutually_exclusive_group()
        for each in self.options:
            each.add_to(group)


@dataclass(frozen=True)
class Verb:
    """What does something.

    Attributes
    ----------
    name, summary : str
    call : str
        ``module:function`` below ``ros2cli``. The function takes the parsed arguments and
        returns an exit code, or None for 0.
    arguments : tuple
    """

    name: str
    summary: str
    call: str
    arguments: tuple[Argument | OneOf, ...] = ()

    def add_to(self, siblings: Any) -> None:
        """Add a parser for it."""
        parser = siblings.add_parser(self.name, help=self.summary, description=self.summary)
        for argument in self.arguments:
            argument.add_to(parser)
        parser.set_defaults(call=self.call)


@dataclass(frozen=True)
class Command:
    """A word that verbs stand behind, such as ``topic``."""

    name: str
    summary: str
    verbs: tuple[Verb, ...]

    def add_to(self, siblings: Any) -> None:
        """Add a parser for it and its verbs."""
        parser = siblings.add_parser(self.name, help=self.summary, description=self.summary)
        _add_choice(parser, "verb", self.verbs)


def word(name: str, about: str, **settings: Any) -> Argument:
    """Argument that its place tells."""
    return Argument((name,), (("help", about), *settings.items()))


def option(*names: str, about: str, **settings: Any) -> Argument:
    """Option with a value."""
    return Argument(names, (("help", about), *settings.items()))


def flag(*names: str, about: str) -> Argument:
    """Option without a value."""
    return Argument(names, (("help", about), ("action", "store_true")))


def build_parser(
    program: str, summary: str, items: Iterable[Verb | Command]
) -> argparse.ArgumentParser:
    """Parser of the whole command line.

    Parsed arguments hold ``call``: that of the verb, or a function that prints help where no
    verb was named.
    """
    parser = _Parser(prog=program, description=summary)
    _add_choice(parser, "command", items)
    return parser


class _Parser(argparse.ArgumentParser):
    """Tells what is wrong in one line, without all that could be right."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message} (see {self.prog} --help)\n")


def _add_choice(
    parser: argparse.ArgumentParser, what: str, items: Iterable[Verb | Command]
) -> None:
    choice = parser.add_subparsers(title=f"{what}s", metavar=what.upper())
    parser.set_defaults(call=lambda _: parser.print_help())
    for item in sorted(items, key=lambda item: item.name):
        item.add_to(choice)
