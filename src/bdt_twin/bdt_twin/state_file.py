"""The state file of a twin: written whole or not at all, read back with its age."""

import json
import os
import tempfile
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from bdt_msgs_py.folder_sync import sync_folder
from bdt_twin.twin_state import Document, TwinState, document_of, state_from

FORMAT = "state of a digital twin, 1"
BEGINNING = b'{"format": "state of a digital twin'
"""What each state file begins with: a file that does not is somebody else's."""
LARGEST_SIZE = 1_000_000
"""Size of a state file [B]; it has some 5000."""
FUTURE = 60.0
"""Time [s] by which a clock may have been set back since a state was written."""


class StateFileError(ValueError):
    """A state file is of no use; the text is one line that says why.

    Parameters
    ----------
    text : str
        Why.
    is_foreign : bool
        Whether it belongs to somebody else, and must not be overwritten.
    """

    def __init__(self, text: str, *, is_foreign: bool = False) -> None:
        super().__init__(text)
        self.is_foreign = is_foreign


class StoredState(NamedTuple):
    """A state that was read back, and its age [s]."""

    state: TwinState
    age: float


def write_state(path: Path, state: TwinState, now: float) -> None:
    """Write a state so that a crash or a power cut leaves this one or the one before.

    Parameters
    ----------
    path : Path
        The file.
    state : TwinState
        What to write.
    now : float
        Wall time [s] since 1970.

    Raises
    ------
    OSError
        If it cannot be written; what was there before still is.
    """
    document = document_of(state)
    text = json.dumps(
        {
            "format": FORMAT,
            "written_at": now,
            "checksum": _checksum(now, document),
            "state": document,
        },
        allow_nan=False,
    )
    descriptor, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            file.write(f"{text}\n")
            file.flush()
            os.fsync(file.fileno())
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    sync_folder(path.parent)


def read_state(
    path: Path,
    controller: str,
    mechanism: dict[str, float | str],
    now: float,
    longest_age: float,
) -> StoredState | None:
    """Read a state back.

    Parameters
    ----------
    path : Path
        The file.
    controller : str
        Name of the controller's node with its namespace.
    mechanism : dict
        From :func:`bdt_twin.twin_state.mechanism_of`.
    now : float
        Wall time [s] since 1970.
    longest_age : float
        Age [s] up to which a state is of use.

    Returns
    -------
    StoredState or None
        None if there is no such file.

    Raises
    ------
    StateFileError
        If it cannot be read, is torn, is not of a twin, this controller or this mechanism, or is
        too old.
    """
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_SIZE)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise StateFileError(f"cannot be read: {error.strerror}") from error
    if data and not data.startswith(BEGINNING[: len(data)]):
        raise StateFileError("is not the state file of a twin: left alone", is_foreign=True)
    try:
        whole = json.loads(data)
        written_at, document = float(whole["written_at"]), whole["state"]
        is_whole = whole["checksum"] == _checksum(written_at, document)
        state = state_from(document) if is_whole and whole["format"] == FORMAT else None
    except (KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
        raise StateFileError(f"is torn or damaged ({type(error).__name__})") from error
    if state is None:
        raise StateFileError("is damaged, or of another version")
    if state.controller != controller:
        raise StateFileError(
            f"is of the controller {state.controller}, not {controller}: left alone",
            is_foreign=True,
        )
    if other := _other_than(state.mechanism, mechanism):
        raise StateFileError(f"is of another mechanism: {other}")
    age = now - written_at
    if age < -FUTURE:
        raise StateFileError(f"was written {-age:.0f} s from now: the clock was set back")
    if age > longest_age:
        raise StateFileError(f"is {age:.0f} s old: must be {longest_age:g} s at most")
    return StoredState(state, max(age, 0.0))


def _other_than(kept: object, mechanism: dict[str, float | str]) -> str:
    """Return in what a mechanism differs from the one that was kept; empty if in nothing."""
    before = kept if isinstance(kept, dict) else {}
    for name, value in mechanism.items():
        if before.get(name) != value:
            return f"{name} was {before.get(name)}, is {value}"
    return ""


def _checksum(now: float, document: Document) -> str:
    canonical = json.dumps([now, document], sort_keys=True, allow_nan=False)
    return sha256(canonical.encode()).hexdigest()
