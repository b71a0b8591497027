"""Executables of packages, found where pip has put them."""

from importlib.metadata import Distribution, EntryPoint, PackageNotFoundError, distributions

from ros2cli.errors import CommandError

__all__ = ["executables_of", "find_executable", "package_names"]


def _name(distribution: Distribution) -> str:
    return str(distribution.metadata["Name"]).replace("-", "_").lower()


def _entry_points(distribution: Distribution) -> list[EntryPoint]:
    return [entry for entry in distribution.entry_points if entry.group == "console_scripts"]


def package_names() -> list[str]:
    """Packages that offer an executable, sorted; names with underscores as in ROS."""
    return sorted({_name(found) for found in distributions() if _entry_points(found)})


def executables_of(package: str) -> list[EntryPoint]:
    """Executables of a package, sorted by name."""
    try:
        distribution = Distribution.from_name(package.replace("_", "-"))
    except (PackageNotFoundError, ValueError):
        raise CommandError(f"Package '{package}' not found") from None
    return sorted(_entry_points(distribution), key=lambda entry: entry.name)


def find_executable(package: str, name: str) -> EntryPoint:
    """Executable of a package."""
    for entry in executables_of(package):
        if entry.name == name:
            return entry
    raise CommandError("No executable found")
