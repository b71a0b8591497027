"""A file for each time that somebody worked on a folder: when, on what, with which versions."""

import json
import os
import platform
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from bdt_msgs_py.output_files import not_writable
from bdt_study.engine.part_folder import write_whole

SESSIONS = "sessions"
VERSIONS = ("bdt_study", "numpy", "scipy", "numba", "pyarrow")


def write_session(folder: Path) -> None:
    """Write what is known now.

    Parameters
    ----------
    folder : Path
        Folder that is worked on.

    Raises
    ------
    BadInputError
        If it cannot be written.
    """
    began = datetime.now(UTC)
    session = {
        "began": began.isoformat(timespec="seconds"),
        "machine": platform.node(),
        "processor": platform.machine(),
        "system": platform.platform(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        **{name: version(name) for name in VERSIONS},
    }
    path = folder / SESSIONS / f"{began:%Y%m%dT%H%M%S%f}.json"
    try:
        path.parent.mkdir(exist_ok=True)
        write_whole(path, (json.dumps(session, indent=2) + "\n").encode())
    except OSError as error:
        raise not_writable("--output", folder, error) from error
