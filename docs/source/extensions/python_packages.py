"""Which Python packages and modules this project has, and what a page says without them."""

import json
import pkgutil
import shutil
from importlib.util import find_spec
from pathlib import Path

from docutils import nodes
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

PACKAGES = (
    "bdt_msgs_py",
    "bdt_plant",
    "bdt_controller",
    "bdt_driver",
    "bdt_serial_drive",
    "bdt_drive_emulator",
    "bdt_twin",
    "bdt_bags",
    "bdt_analysis",
    "bdt_study",
    "bdt_bringup",
    "bdt_live",
)


def package_contents() -> dict[str, dict[str, list[str]]]:
    """Return what each package, and each package within one, holds.

    Returns
    -------
    dict
        For each name the full names of its ``packages`` and ``modules``; nothing of a package that
        is not installed.
    """
    contents: dict[str, dict[str, list[str]]] = {}
    for package in PACKAGES:
        spec = find_spec(package)
        if spec is None or spec.submodule_search_locations is None:
            continue
        contents[package] = {"packages": [], "modules": []}
        for item in pkgutil.walk_packages(spec.submodule_search_locations, f"{package}."):
            within = contents[item.name.rpartition(".")[0]]
            within["packages" if item.ispkg else "modules"].append(item.name)
            if item.ispkg:
                contents[item.name] = {"packages": [], "modules": []}
    return contents


def forget_old_pages(folder: Path, contents: dict[str, dict[str, list[str]]]) -> None:
    """Remove generated pages that were made of other modules.

    Sphinx looks for all that pages list which an earlier build has left, and warns of what is gone.

    Parameters
    ----------
    folder : Path
        Folder of generated pages, which keeps a note of what they were made of.
    contents : dict
        What there is now, from :func:`package_contents`.
    """
    note, now = folder / "contents.json", json.dumps(contents)
    if not note.is_file() or note.read_text(encoding="utf-8") != now:
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        note.write_text(now, encoding="utf-8")


def left_out(directive: SphinxDirective, error: ImportError) -> list[nodes.Node]:
    """Return what stands in place of something that is made from code that is not installed.

    It is a warning, which ends `make docs`. A build farm, which has no numpy, goes on.
    """
    text = f"{directive.name} is left out: {error}. `make docs` has it."
    logging.getLogger(__name__).warning(text, location=directive.get_location())
    return [nodes.note("", nodes.paragraph(text=text))]
