"""Which packages the source files of a package import, read from their syntax alone."""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

IMPORTING_FUNCTIONS = ("import_module", "find_spec")
"""Functions of the standard library that take the name of a module; only literal ones count."""

LATER_IN_PYTHON = {"compression"}
"""Modules of the standard library of a Python newer than the one that runs the check."""


def imported_packages(folder: Path) -> dict[str, str]:
    """Return what the files of a package import, wherever in a file that stands.

    Parameters
    ----------
    folder : Path
        Folder with the package's ``__init__.py``.

    Returns
    -------
    dict
        For the name of each top-level package, without the standard library and the package
        itself, the first place that imports it: ``file:line``.
    """
    places: dict[str, str] = {}
    for file in sorted(folder.rglob("*.py")):
        for module, line in _imports(ast.parse(file.read_text(encoding="utf-8"))):
            name = module.partition(".")[0]
            if name not in {folder.name, *LATER_IN_PYTHON, *sys.stdlib_module_names}:
                places.setdefault(name, f"{file}:{line}")
    return places


def _imports(tree: ast.Module) -> Iterator[tuple[str, int]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name, node.lineno
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module, node.lineno
        elif isinstance(node, ast.Call) and node.args and _name(node.func) in IMPORTING_FUNCTIONS:
            first = node.args[0]
            if isinstance(first, ast.Constant) and isinstance(first.value, str):
                yield first.value, node.lineno


def _name(function: ast.expr) -> str | None:
    if isinstance(function, ast.Attribute):
        return function.attr
    return function.id if isinstance(function, ast.Name) else None
