"""Files that a command is to write, tried before the work that they are the result of."""

import os
from collections.abc import Collection
from pathlib import Path

from bdt_msgs_py.command_errors import BadInputError

PICTURES = (".png", ".svg", ".pdf")
"""Endings of pictures; what has another one a plotting library would name as it likes."""


def prepare_output(option: str, path: Path, endings: Collection[str] = ()) -> None:
    """Create the folder of a file and try to write there; a file that exists stays as it is.

    Parameters
    ----------
    option : str
        What the user gave, for example ``--figure``.
    path : Path
        The file.
    endings : collection of str, optional
        Endings of which it must have one.

    Raises
    ------
    BadInputError
        If the file cannot be written.
    """
    if endings and path.suffix not in endings:
        *most, last = endings
        allowed = f"{', '.join(most)} or {last}" if most else last
        raise BadInputError(f"{option} {path}: must end with {allowed}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        is_new = not os.path.lexists(path)
        with path.open("ab"):
            pass
        if is_new:
            path.unlink()
    except OSError as error:
        raise not_writable(option, path, error) from error


def not_writable(option: str, path: Path, error: OSError) -> BadInputError:
    """Return the error of a file or folder that cannot be written."""
    return BadInputError(f"{option} {path}: cannot be written: {error.strerror or error}")


def real_path(path: Path) -> Path:
    """Return a path without symbolic links; links in a circle stay as they are."""
    return Path(os.path.realpath(path))
