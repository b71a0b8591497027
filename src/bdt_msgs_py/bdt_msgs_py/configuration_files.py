"""Configurations that come with packages: found by name, wherever they are installed.

A package names itself in the entry-point group ``bdt.configurations``; its folder ``config`` holds
ROS parameter files.
"""

from importlib.metadata import entry_points
from importlib.resources import files
from pathlib import Path

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_tables import suggestion

CONFIGURATION_GROUP = "bdt.configurations"


def packaged_configurations() -> dict[str, Path]:
    """Return the configurations that are installed, by name."""
    folders = [
        Path(str(files(point.value) / "config"))
        for point in entry_points(group=CONFIGURATION_GROUP)
    ]
    found = {path.stem: path for folder in folders for path in folder.glob("*.yaml")}
    return dict(sorted(found.items()))


def find_configuration(name: str | None) -> Path | None:
    """Return the file of a configuration.

    Parameters
    ----------
    name : str or None
        A file, or the name of a packaged configuration; a file of that very name comes first.
        None for the defaults.

    Returns
    -------
    Path or None
        The file, which may be missing; None for the defaults.

    Raises
    ------
    BadInputError
        For what is neither a file nor a packaged configuration.
    """
    if name is None:
        return None
    packaged = packaged_configurations()
    path = Path(name)
    if path.is_file() or (name not in packaged and (path.suffix or path.parent != Path())):
        return path
    if name not in packaged:
        raise BadInputError(
            f"--config {name}: is no file, and no packaged configuration: must be one of "
            f"{', '.join(packaged)}{suggestion(name, packaged)}"
        )
    return packaged[name]
