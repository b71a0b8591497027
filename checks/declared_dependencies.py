"""What a package declares that it needs: in package.xml for rosdep, in setup.py for pip."""

import ast
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET


@dataclass(frozen=True)
class DeclaredDependencies:
    """Dependencies of a package.

    Attributes
    ----------
    rosdep_keys : frozenset of str
        ``exec_depend`` of package.xml: ROS packages and keys of rosdep.
    required : frozenset of str
        Distributions that pip installs with the package, in normal form.
    optional : frozenset of str
        Distributions that extras of the package name, in normal form.
    """

    rosdep_keys: frozenset[str]
    required: frozenset[str]
    optional: frozenset[str]


def declared_dependencies(package: Path) -> DeclaredDependencies:
    """Return what a folder with package.xml and setup.py declares.

    Raises
    ------
    ValueError
        If setup.py gives its requirements other than as literals.
    """
    manifest = ET.parse(package / "package.xml")
    setup = package / "setup.py"
    extras = _literal_argument(setup, "extras_require", {})
    return DeclaredDependencies(
        rosdep_keys=frozenset(str(tag.text).strip() for tag in manifest.iter("exec_depend")),
        required=_distributions(_literal_argument(setup, "install_requires", [])),
        optional=_distributions(name for names in extras.values() for name in names),
    )


def normal_form(distribution: str) -> str:
    """Return the name of a distribution as indexes compare it: ``ruamel.yaml`` is ``ruamel-yaml``.

    >>> normal_form("bdt_msgs_py")
    'bdt-msgs-py'
    """
    return re.sub(r"[-_.]+", "-", distribution).lower()


def _distributions(requirements: Any) -> frozenset[str]:
    return frozenset(
        normal_form(re.split(r"[^\w.-]", text, maxsplit=1)[0]) for text in requirements
    )


def _literal_argument(setup: Path, name: str, default: Any) -> Any:
    for node in ast.walk(ast.parse(setup.read_text(encoding="utf-8"))):
        if isinstance(node, ast.keyword) and node.arg == name:
            try:
                return ast.literal_eval(node.value)
            except ValueError as error:
                raise ValueError(f"{setup}: {name}: must be written as literals") from error
    return default
