"""Subcommands of ``bdt``: what a package offers under the entry-point group ``bdt.command``.

The module that an entry point names is imported for every ``bdt --help``. What a command computes
with is therefore imported by its `run`, not by that module.
"""

from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from dataclasses import dataclass

COMMAND_GROUP = "bdt.command"
"""Entry points of subcommands: name of the subcommand, and the :class:`Command` that it is."""

NODE_GROUP = "bdt.node"
"""Entry points of nodes: name of the node, and its class; the module has a ``main``."""

BENCHMARK_GROUP = "bdt.benchmark"
"""Entry points of benchmarks that ``bdt bench`` runs when they are named: a function of the time
[s] that a loop in real time is measured, which returns a dict for each number, with ``name``,
``value``, ``unit``, ``reference``, ``reference_value`` and ``ratio``."""

PARAMETER_GROUP = "bdt.parameters"
"""Entry points of parameter tables: name of the node, and its table, which needs no ROS."""


@dataclass(frozen=True)
class Command:
    """A subcommand of ``bdt``.

    Attributes
    ----------
    summary : str
        What it does, in a few words for the list of commands.
    description : str
        What its own help says above the options.
    add_arguments : callable
        Adds the arguments to its parser.
    run : callable
        Does the work and returns the exit code. It may raise
        :class:`~bdt_msgs_py.command_errors.BadInputError` and
        :class:`~bdt_msgs_py.command_errors.LoopError`, whose text becomes one line.
    """

    summary: str
    description: str
    add_arguments: Callable[[ArgumentParser], None]
    run: Callable[[Namespace], int]
