"""Compares what each package imports with what its package.xml and setup.py declare.

Run as ``python -m checks.check_dependencies [FOLDER ...]``; without folders it checks ``src/*``.
"""

import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from checks.declared_dependencies import (
    DeclaredDependencies,
    declared_dependencies,
    normal_form,
)
from checks.dependency_table import PROVIDERS, UNDECLARED, WITHOUT_ROSDEP, Provider
from checks.imported_packages import imported_packages

SOURCES = Path("src")
OWN_PREFIX = "bdt_"


def main() -> None:
    """Print what is missing and what is superfluous, one line each, and exit with 1 for any."""
    folders = [Path(name) for name in sys.argv[1:]] or sorted(
        file.parent for file in SOURCES.glob("*/package.xml")
    )
    problems = [problem for folder in folders for problem in dependency_problems(folder)]
    problems += idle_exceptions({folder.name: set(_imports(folder)) for folder in folders})
    for problem in problems:
        print(f"error: {problem}", file=sys.stderr)
    if problems:
        sys.exit(1)
    print(f"dependencies of {len(folders)} packages: nothing missing, nothing superfluous")


def dependency_problems(folder: Path) -> list[str]:
    """Return what a package declares too little or too much, one line each.

    Parameters
    ----------
    folder : Path
        Folder with package.xml, setup.py and the Python package of the folder's name.
    """
    package = folder.name
    imports = _imports(folder)
    declared = declared_dependencies(folder)
    unknown = [name for name in imports if _provider(name) is None]
    return [
        *(f"{imports[name]}: {name}: is not in checks/dependency_table.py" for name in unknown),
        *_package_xml_problems(package, imports, declared),
        *_setup_problems(package, imports, declared),
    ]


def idle_exceptions(imports: Mapping[str, set[str]]) -> list[str]:
    """Return the exceptions of the table that nothing needs any more.

    Parameters
    ----------
    imports : mapping of str to set of str
        What each package imports; exceptions of other packages are not judged.
    """
    return [
        f"checks/dependency_table.py: {package}: imports no {name}"
        for package, name in (*WITHOUT_ROSDEP, *UNDECLARED)
        if package in imports and name not in imports[package]
    ]


def _imports(folder: Path) -> dict[str, str]:
    return imported_packages(folder / folder.name)


def _provider(name: str) -> Provider | None:
    if name.startswith(OWN_PREFIX):
        return Provider(name, name)
    return PROVIDERS.get(name)


def _package_xml_problems(
    package: str, imports: Mapping[str, str], declared: DeclaredDependencies
) -> Iterator[str]:
    needed = set()
    for name, place in imports.items():
        provider = _provider(name)
        if provider is None or (package, name) in {**UNDECLARED, **WITHOUT_ROSDEP}:
            continue
        needed.add(provider.rosdep_key)
        if provider.rosdep_key not in declared.rosdep_keys:
            key = provider.rosdep_key or "no key known: give a reason in checks/dependency_table.py"
            yield f"{package}/package.xml: exec_depend is missing: {key} ({place} imports {name})"
    for key in sorted(declared.rosdep_keys - needed):
        yield f"{package}/package.xml: exec_depend is superfluous: {key}"


def _setup_problems(
    package: str, imports: Mapping[str, str], declared: DeclaredDependencies
) -> Iterator[str]:
    needed = set()
    for name, place in imports.items():
        provider = _provider(name)
        if provider is None or provider.distribution is None or (package, name) in UNDECLARED:
            continue
        distribution = normal_form(provider.distribution)
        needed.add(distribution)
        if distribution not in declared.required | declared.optional:
            what = provider.distribution
            yield f"{package}/setup.py: install_requires lacks {what} ({place} imports {name})"
    for distribution in sorted((declared.required | declared.optional) - needed):
        yield f"{package}/setup.py: {distribution} is superfluous"
    for distribution in sorted(declared.required & declared.optional):
        yield f"{package}/setup.py: {distribution} is required, so no extra needs it"


if __name__ == "__main__":
    main()
