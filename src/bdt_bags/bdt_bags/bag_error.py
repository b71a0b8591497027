"""The error of everything that is wrong with a bag."""

from bdt_msgs_py.command_errors import BadInputError, printable


class BagError(BadInputError):
    """A bag or an output folder cannot be used; one line that says why and what is required."""


def one_line(error: BaseException) -> str:
    """Return what an exception says, in one line of at most 300 characters, never empty."""
    text = printable(str(error)) or type(error).__name__
    return text if len(text) <= 300 else text[:297] + "..."
