"""Quantities as options of a command: ``--split-size`` for the field ``split_size``."""

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from typing import Any

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.quantities import quantities_of


def add_quantity_options(
    command: ArgumentParser, parameters: type[Any], names: Sequence[str]
) -> None:
    """Add an option for each of some fields; :func:`quantities_from_options` reads them.

    Parameters
    ----------
    command : argparse.ArgumentParser
        Gets the options.
    parameters : type
        Dataclass whose fields are quantities, numbers or texts.
    names : sequence of str
        The fields.
    """
    known = {name: (default, described) for name, default, described in quantities_of(parameters)}
    for name in names:
        default, described = known[name]
        choices = f": {' or '.join(described.choices)}" if described.choices else ""
        command.add_argument(
            _option(name),
            # A number is checked with its bounds, together with the others.
            type=type(default),
            default=default,
            metavar=described.unit.upper() or "KIND",
            help=f"{described.description}{choices} (default: %(default)s)",
        )


def quantities_from_options(
    parameters: type[Any], options: Namespace, names: Sequence[str], **others: Any
) -> Any:
    """Return the dataclass that the options tell.

    Parameters
    ----------
    parameters : type
        The dataclass.
    options : argparse.Namespace
        Parsed options.
    names : sequence of str
        Fields that are options.
    **others
        Values of other fields.

    Raises
    ------
    BadInputError
        With one line that names the option, the value and what is allowed.
    """
    values = {name: getattr(options, name) for name in names}
    try:
        return parameters(**values, **others)
    except ValueError as error:
        text = str(error)
        for name in names:
            text = text.replace(f"{parameters.__name__}.{name} ", f"{_option(name)} ")
        raise BadInputError(text) from error


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"
