"""A folder of Parquet files, a part for each job, whole at any moment.

A part gets its name when it is whole, so whoever reads the folder sees what is finished only, and
what a killed program was writing is not there.
"""

import json
import os
from abc import ABC, abstractmethod
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic

import pyarrow as pa
from pyarrow import parquet

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.folder_sync import create_folder, sync_folder
from bdt_msgs_py.output_files import not_writable
from bdt_study.engine.job import Result

PARTS = "runs"
"""Folder of the parts within the whole one."""
UNFINISHED = ".{}.unfinished"
"""Name of a file while it is written, with its later one: readers of Parquet pass over it."""


@dataclass(frozen=True)
class Identity:
    """By what the parts in a folder belong together, so that it is known what is gone on with.

    Attributes
    ----------
    content : str
        What is in the folder, in a word: ``sweep``.
    file_name : str
        Name of the file with the text, after what the content follows from: ``study.json``.
    text : str
        All that the content follows from, the program's version as well: a JSON object.
    """

    content: str
    file_name: str
    text: str


class PartFolder(ABC, Generic[Result]):
    """The parts, each made of the result of a job.

    Parameters
    ----------
    folder : Path
        The folder.
    identity : Identity
        What its parts are parts of.
    count : int
        Number of parts when it is finished.
    """

    def __init__(self, folder: Path, identity: Identity, count: int) -> None:
        self.folder = folder
        self.parts_folder = folder / PARTS
        self._identity = identity
        self._count = count

    @abstractmethod
    def table(self, result: Result) -> Any:
        """Return what a job gave as the rows of its part, a ``pyarrow.Table``."""

    def create(self, *, resume: bool) -> None:
        """Create the folder, or take up what is there.

        Parameters
        ----------
        resume : bool
            Whether parts that are there count.

        Raises
        ------
        BadInputError
            If the folder holds something else, parts of something else, or parts that nobody wants
            to resume.
        """
        label = f"--output {self.folder}"
        known = self.folder / self._identity.file_name
        content = self._identity.content
        try:
            if known.exists():
                self._check_identity(known, label)
                if not resume:
                    raise BadInputError(
                        f"{label}: already holds this {content}: go on with --resume"
                    )
            elif self.folder.exists() and not self._is_empty():
                raise BadInputError(
                    f"{label}: holds something that is no {content}, must be a new or empty folder"
                )
            create_folder(self.folder)
            if not known.exists():
                # Before all else: by this the folder is known, however soon the program is killed.
                write_whole(known, self._identity.text.encode() + b"\n")
            create_folder(self.parts_folder)
            for left in self.parts_folder.glob(UNFINISHED.format("*")):
                left.unlink()
        except OSError as error:
            raise not_writable("--output", self.folder, error) from error

    def missing(self) -> list[int]:
        """Return the numbers of the jobs that have no part yet."""
        there = {path.name for path in self.parts_folder.glob("*.parquet")}
        return [number for number in range(self._count) if part_name(number) not in there]

    def write(self, number: int, result: Result) -> None:
        """Write the part of a job.

        Raises
        ------
        OSError
            If it cannot be written; nothing of it is left then.
        """
        sink = pa.BufferOutputStream()
        parquet.write_table(self.table(result), sink, compression="zstd")
        write_whole(self.parts_folder / part_name(number), sink.getvalue().to_pybytes())

    def _check_identity(self, known: Path, label: str) -> None:
        text = known.read_text(encoding="utf-8").strip()
        if text == self._identity.text:
            return
        try:
            other = json.loads(text)
            differing = [
                key for key, value in json.loads(self._identity.text).items() if other[key] != value
            ]
        except (ValueError, KeyError, TypeError) as error:
            raise BadInputError(f"{label}: its {known.name} cannot be read") from error
        raise BadInputError(
            f"{label}: is the data set of another {known.stem} or version, which differs in "
            f"{', '.join(differing)}"
        )

    def _is_empty(self) -> bool:
        """Tell whether there is nothing but what a killed program left of its first file."""
        first = UNFINISHED.format(self._identity.file_name)
        return self.folder.is_dir() and all(path.name == first for path in self.folder.iterdir())


def part_name(number: int) -> str:
    """Return the name of a part."""
    return f"part-{number:07d}.parquet"


def write_whole(path: Path, content: bytes) -> None:
    """Write a file that is whole once it has its name, also after a power cut.

    Raises
    ------
    OSError
        If it cannot be written; nothing of it is left then.
    """
    unfinished = path.with_name(UNFINISHED.format(path.name))
    try:
        with unfinished.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        unfinished.replace(path)
    except BaseException:
        with suppress(OSError):
            unfinished.unlink()
        raise
    sync_folder(path.parent)
