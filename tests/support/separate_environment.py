"""Virtual environments with exactly what some distributions require, without a download.

Each distribution is linked from the environment that runs the tests. Which ones follows from their
metadata, so a package that imports more than it requires fails there.
"""

import json
import os
import signal
import subprocess
import sysconfig
import venv
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from importlib.metadata import Distribution
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from checks.required_distributions import required_distributions

TIMEOUT = 60.0
"""Wall time [s] after which a program counts as hanging."""

SCRIPT = """#!{python}
import sys
from {module} import {attribute}
sys.exit({attribute}())
"""


class SeparateEnvironment:
    """A virtual environment.

    Parameters
    ----------
    folder : Path
        Where it is made.
    names : iterable of str
        Distributions that are installed into it, with all that they require.
    without : collection of str
        Distributions that are left out although one requires them.
    """

    def __init__(
        self, folder: Path, names: Iterable[str], *, without: Collection[str] = ()
    ) -> None:
        self.distributions = required_distributions(names, without=without)
        venv.create(folder, symlinks=True)
        self._programs = folder / "bin"
        paths = {"base": str(folder), "platbase": str(folder)}
        packages = Path(sysconfig.get_path("purelib", "venv", paths))
        for distribution in self.distributions.values():
            _link(distribution, packages)
            self._write_scripts(distribution)

    def run(self, *command: str) -> "subprocess.CompletedProcess[str]":
        """Run a program of the environment to its end."""
        return subprocess.run(
            self._command(command), check=False, timeout=TIMEOUT, **self._options()
        )

    @contextmanager
    def running(self, *command: str) -> Iterator["subprocess.Popen[str]"]:
        """Run a program of the environment meanwhile, and end it as Ctrl-C does."""
        with subprocess.Popen(self._command(command), **self._options()) as process:
            try:
                yield process
                process.send_signal(signal.SIGINT)
                process.wait(TIMEOUT)
            finally:
                process.kill()

    def _command(self, command: tuple[str, ...]) -> list[str]:
        program, *arguments = command
        return [str(self._programs / program), *arguments]

    def _options(self) -> dict[str, Any]:
        # Nothing of the environment that runs the tests, and no folder of the repository.
        variables = {
            name: value for name, value in os.environ.items() if not name.startswith("PYTHON")
        }
        return {
            "cwd": self._programs.parent,
            "env": {**variables, "PYTHONNOUSERSITE": "1"},
            "stdout": subprocess.PIPE,
            "stderr": subprocess.PIPE,
            "text": True,
        }

    def _write_scripts(self, distribution: Distribution) -> None:
        for entry in distribution.entry_points:
            if entry.group == "console_scripts":
                script = self._programs / entry.name
                script.write_text(
                    SCRIPT.format(
                        python=self._programs / "python",
                        module=entry.module,
                        attribute=entry.attr,
                    )
                )
                script.chmod(0o755)


def _link(distribution: Distribution, packages: Path) -> None:
    """Link the files of a distribution, those of an edited one from its sources."""
    places = {file.parts[0]: distribution.locate_file(file.parts[0]) for file in distribution.files}
    edited = json.loads(distribution.read_text("direct_url.json") or "{}")
    if edited.get("dir_info", {}).get("editable"):
        sources = Path(unquote(urlsplit(edited["url"]).path))
        places = {name: place for name, place in places.items() if name.endswith(".dist-info")}
        for name in distribution.read_text("top_level.txt").split():
            (found,) = [x for x in (sources / name, sources / "src" / name) if x.is_dir()]
            places[name] = found
    for name, place in places.items():
        # Scripts are written anew, and compiled modules of one file each are found elsewhere.
        if name not in {"..", "__pycache__"}:
            (packages / name).symlink_to(place)
