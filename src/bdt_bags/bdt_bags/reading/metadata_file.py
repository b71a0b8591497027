"""Which files make up a rosbag2 folder: ``metadata.yaml``, read with care."""

from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

import yaml

from bdt_bags.bag_error import BagError, one_line
from bdt_bags.bag_format import METADATA_FILE, NEWEST_VERSION, STORAGE_OF_SUFFIX
from bdt_bags.file_checksums import PREFIX

LARGEST_METADATA = 2**21
"""Size of metadata.yaml [bytes]: that of a bag of 10 000 files; it is read in four seconds."""

DEEPEST = 30
"""Depth of nesting; rosbag2 needs 7."""

STORAGES = tuple(STORAGE_OF_SUFFIX.values())


class RecordedFile(NamedTuple):
    """A file of a bag, and its checksum as eight hexadecimal digits; "" where none is told."""

    path: Path
    checksum: str


def recorded_files(folder: Path) -> list[RecordedFile]:
    """Return the files of a bag in their order.

    Only the list of files and their checksums are taken from the metadata: topics, types and
    counts are those of the files themselves.

    Parameters
    ----------
    folder : Path
        Folder with ``metadata.yaml``.

    Raises
    ------
    BagError
        If the metadata are damaged, of another version, or name a file that is not there.
    OSError
        If they cannot be read.
    """
    information = _information(folder / METADATA_FILE)
    version = information.get("version")
    if not isinstance(version, int) or not 1 <= version <= NEWEST_VERSION:
        raise BagError(f"has rosbag2 version {_short(version)}: must be 1 to {NEWEST_VERSION}")
    storage = information.get("storage_identifier")
    if storage not in STORAGES:
        raise BagError(f"has storage {_short(storage)}: must be one of {', '.join(STORAGES)}")
    compression = information.get("compression_format") or "zstd"
    if compression != "zstd":
        raise BagError(f"has compression format {_short(compression)}: must be zstd")
    names = information.get("relative_file_paths")
    if not isinstance(names, list) or not names or not all(isinstance(x, str) for x in names):
        raise BagError("has metadata without relative_file_paths: must be a list of files")
    # Before version 4 the paths began with the folder of the bag.
    files = [folder / PurePosixPath(name).name for name in names]
    if len(set(files)) != len(files):
        raise BagError("has metadata that name a file twice: must not")
    missing = [file.name for file in files if not file.is_file()]
    if missing:
        raise BagError(f"lacks the file {_short(missing[0])} of its metadata")
    custom = information.get("custom_data")
    told = custom if isinstance(custom, dict) else {}
    return [RecordedFile(file, str(told.get(f"{PREFIX}{file.name}", ""))) for file in files]


def _information(path: Path) -> Mapping[str, Any]:
    size = path.stat().st_size
    if size > LARGEST_METADATA:
        raise BagError(f"has {METADATA_FILE} of {size} bytes: must be {LARGEST_METADATA} or less")
    try:
        text = path.read_bytes().decode("utf-8")
        _check_nesting(text)
        content = yaml.load(text, Loader=yaml.CSafeLoader)
    except BagError:
        raise
    except (yaml.YAMLError, ValueError) as error:
        # ValueError: not UTF-8, or a date or number that is none.
        raise BagError(f"has a damaged {METADATA_FILE}: {one_line(error)}") from None
    information = content.get("rosbag2_bagfile_information") if isinstance(content, dict) else None
    if not isinstance(information, dict):
        raise BagError(
            f"has {METADATA_FILE} without rosbag2_bagfile_information: is no rosbag2 bag"
        )
    return information


def _check_nesting(text: str) -> None:
    """Refuse what makes a short text large or deep: aliases and nesting."""
    depth = 0
    for event in yaml.parse(text, Loader=yaml.CSafeLoader):
        if isinstance(event, yaml.AliasEvent):
            raise BagError(
                f"has {METADATA_FILE} with the alias {_short(event.anchor)}: must have none"
            )
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            raise BagError(f"has {METADATA_FILE} nested deeper than {DEEPEST}: must not")


def _short(value: object) -> str:
    return repr(value)[:60]
