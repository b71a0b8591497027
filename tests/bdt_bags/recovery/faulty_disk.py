"""A model of a disk that loses power: what was not synced may be there, not there, or in part.

It is stricter than any file system in use. Only ``fsync`` of a file carries its content to the
disk, only ``fsync`` of a folder carries the names in it; until then each sector holds any of the
contents that were written to it, or zeros, and each name may be missing.
"""

import os
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import ClassVar

import apsw
import numpy as np

SECTOR = 512
RENAME_CUTS = 10
"""Times that the power is cut after a file was renamed."""
VFS_NAME = "faulty_disk"


class FaultyDisk:
    """Watches a folder by the calls that change it.

    Parameters
    ----------
    root : Path
        Folder that survives by itself.
    changed : callable
        Called after every step at which the power may be cut.
    """

    def __init__(self, root: Path, changed: Callable[[], object]) -> None:
        self._root = root
        self._changed = changed
        self._names: dict[Path, int] = {}
        self._versions: list[list[bytes]] = []
        self._folders: set[int] = set()
        # A name that appears, goes, or replaces another: (old or None, new or None, content).
        self._safe_names: dict[Path, int] = {}
        self._unsafe: list[tuple[Path | None, Path | None, int]] = []

    def look(self) -> None:
        """Take down new names and contents."""
        for path in sorted(self._root.rglob("*")):
            if path not in self._names:
                self._names[path] = len(self._versions)
                self._unsafe.append((None, path, len(self._versions)))
                self._versions.append([b""])
                if path.is_dir():
                    self._folders.add(len(self._versions) - 1)
            versions = self._versions[self._names[path]]
            if not path.is_dir() and (content := path.read_bytes()) != versions[-1]:
                versions.append(content)
        self._changed()

    def move(self, old: Path, new: Path | None) -> None:
        """Take down that a file was renamed, or removed."""
        number = self._names.pop(old)
        self._unsafe.append((old, new, number))
        if new is not None:
            self._names[new] = number
        # Renames are few, and each may survive without the names before it.
        for _ in range(1 if new is None else RENAME_CUTS):
            self._changed()

    def synced(self, path: Path) -> None:
        """Take down that a file or a folder was synced."""
        if path.is_dir():
            own = [
                entry for entry in self._unsafe if path in {one and one.parent for one in entry[:2]}
            ]
            self._unsafe = [entry for entry in self._unsafe if entry not in own]
            _apply(own, self._safe_names)
        elif path in self._names:
            versions = self._versions[self._names[path]]
            del versions[:-1]
        self._changed()

    def remains(self, choice: np.random.Generator) -> dict[Path, bytes]:
        """Return one of the states that a power cut may leave: contents of files by path."""
        names = dict(self._safe_names)
        luck = choice.choice([0.0, 0.5, 1.0])
        _apply([entry for entry in self._unsafe if choice.random() < luck], names)
        luck = choice.choice([0.0, 0.5, 0.9, 1.0])
        return {
            path: self._content(number, luck, choice)
            for path, number in names.items()
            if number not in self._folders
            and all(one in names for one in path.parents if self._root in one.parents)
        }

    def _content(self, number: int, luck: float, choice: np.random.Generator) -> bytes:
        safe, *later = self._versions[number]
        if not later:
            return safe
        sizes = [len(safe), *map(len, later)]
        size = choice.choice([*sizes, choice.integers(min(sizes), max(sizes), endpoint=True)])
        content = bytearray(size)
        for begin in range(0, size, SECTOR):
            version = later[choice.integers(len(later))] if choice.random() < luck else safe
            sector = version[begin : min(begin + SECTOR, size)]
            content[begin : begin + len(sector)] = sector
        return bytes(content)


def _apply(entries: list[tuple[Path | None, Path | None, int]], names: dict[Path, int]) -> None:
    for old, new, number in entries:
        if old is not None:
            names.pop(old, None)
        if new is not None:
            names[new] = number


@contextmanager
def watched(disk: FaultyDisk, monkeypatch) -> Iterator[None]:
    """Tell the disk what the recorder does through ``os`` and through sqlite."""
    real = {
        name: getattr(os, name) for name in ("pwrite", "ftruncate", "mkdir", "replace", "unlink")
    }

    def observed(name):
        def call(*arguments, **options):
            result = real[name](*arguments, **options)
            disk.look()
            return result

        return call

    def sync(descriptor):
        disk.look()
        disk.synced(Path(f"/proc/self/fd/{descriptor}").readlink())

    def move(old, new=None):
        disk.look()
        real["replace" if new else "unlink"](*([old, new] if new else [old]))
        disk.move(Path(old), new and Path(new))

    vfs = _WatchedSqlite(disk)
    with monkeypatch.context() as patches:
        for name in ("pwrite", "ftruncate", "mkdir"):
            patches.setattr(os, name, observed(name))
        patches.setattr(os, "fsync", sync)
        patches.setattr(os, "fdatasync", sync)
        patches.setattr(os, "replace", move)
        patches.setattr(os, "unlink", move)
        patches.setattr(sqlite3, "connect", _Connection)
        yield
    vfs.unregister()


@contextmanager
def without_syncs(monkeypatch) -> Iterator[None]:
    """Spare the real disk: what is written here need not survive."""
    connect = sqlite3.connect
    with monkeypatch.context() as patches:
        patches.setattr(os, "fsync", lambda _: None)
        patches.setattr(os, "fdatasync", lambda _: None)
        patches.setattr(sqlite3, "connect", partial(connect, factory=_HastyConnection))
        yield


class _HastyConnection(sqlite3.Connection):
    def execute(self, statement, *arguments):
        hasty = statement.replace("= EXTRA", "= OFF").replace("= NORMAL", "= OFF")
        return super().execute(hasty, *arguments)


class _Connection:
    """As much of a connection of Python's ``sqlite3`` as the recorder uses, by ``apsw``.

    A file system in Python has no memory to share between connections, which a write-ahead log
    needs: all connections to a file are one, which has the file for itself.
    """

    opened: ClassVar[dict[str, tuple[apsw.Connection, list[object]]]] = {}

    def __init__(self, path, **_):
        self._path = str(path)
        if self._path not in self.opened:
            connection = apsw.Connection(self._path, vfs=VFS_NAME)
            connection.execute("PRAGMA locking_mode = EXCLUSIVE")
            self.opened[self._path] = connection, []
        connection, users = self.opened[self._path]
        users.append(self)
        self.execute = self.executescript = connection.execute
        self.executemany = connection.executemany

    def close(self):
        connection, users = self.opened[self._path]
        users.remove(self)
        if not users:
            del self.opened[self._path]
            connection.close()

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        self.execute("COMMIT" if kind is None else "ROLLBACK")


class _WatchedSqlite(apsw.VFS):
    """Sqlite's own way to the disk, watched."""

    def __init__(self, disk):
        super().__init__(VFS_NAME, base="")
        self.disk = disk

    def xOpen(self, name, flags):  # noqa: N802
        return _WatchedFile(self.disk, name, flags)

    def xDelete(self, name, syncdir):  # noqa: N802
        self.disk.look()
        super().xDelete(name, syncdir)
        self.disk.move(Path(name), None)
        if syncdir:
            self.disk.synced(Path(name).parent)


class _WatchedFile(apsw.VFSFile):
    def __init__(self, disk, name, flags):
        self.disk = disk
        self.path = Path(name.filename() if isinstance(name, apsw.URIFilename) else name)
        # With the first sync of a new journal, sqlite's os_unix.c syncs the folder as well.
        self.is_new_journal = flags[0] & apsw.SQLITE_OPEN_MAIN_JOURNAL and not self.path.exists()
        super().__init__("", name, flags)
        disk.look()

    def xWrite(self, data, offset):  # noqa: N802
        super().xWrite(data, offset)
        self.disk.look()

    def xTruncate(self, size):  # noqa: N802
        super().xTruncate(size)
        self.disk.look()

    def xSync(self, flags):  # noqa: N802
        self.disk.look()
        self.disk.synced(self.path)
        if self.is_new_journal:
            self.is_new_journal = False
            self.disk.synced(self.path.parent)
