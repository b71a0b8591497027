"""Makes a whole bag of what is left of one, beside it; the damaged bag stays as it is."""

import re
import shutil
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
import zstandard

from bdt_bags.bag_error import BagError, one_line
from bdt_bags.bag_format import COMPRESSED_SUFFIX, METADATA_FILE, STORAGE_OF_SUFFIX
from bdt_bags.file_checksums import PREFIX
from bdt_bags.reading.bounded_decompression import PIECE, allowed_size
from bdt_bags.recovery.damaged_file import Damage, DamagedFile
from bdt_bags.recovery.damaged_mcap_file import DamagedMcapFile
from bdt_bags.recovery.damaged_sqlite_file import DamagedSqliteFile
from bdt_bags.recovery.decompression import LARGEST_CHUNK, decompressed_zstd
from bdt_bags.writing.bag_files import BagFiles
from bdt_bags.writing.metadata_file import UNFINISHED
from bdt_bags.writing.topic_metadata import BagWriteError, SerializedMessage
from bdt_msgs_py.output_files import real_path

_BATCH = 10_000


@dataclass
class Recovery:
    """What was recovered.

    Attributes
    ----------
    source, output : Path
        The damaged bag and the new one.
    messages : Counter of str
        Number of messages by topic name.
    start, end : int
        Times of the first and the last message [ns].
    damage : dict of str to Damage
        What was not understood, by the file's name.
    """

    source: Path
    output: Path
    messages: Counter[str] = field(default_factory=Counter)
    start: int = 2**63 - 1
    end: int = 0
    damage: dict[str, Damage] = field(default_factory=dict)


def recover_bag(source: Path, output: Path | None = None) -> Recovery:
    """Write a whole bag of what is left in another.

    Parameters
    ----------
    source : Path
        Bag folder, with or without ``metadata.yaml``, or a bare ``.mcap`` or ``.db3`` file. It is
        only read.
    output : Path, optional
        New folder; the default stands beside the source and ends in ``_recovered``.

    Raises
    ------
    BagError
        If there is nothing to recover, or the new bag cannot be written.
    """
    files = _files_of(source)
    kinds = {STORAGE_OF_SUFFIX[_plain_suffix(file)] for file in files}
    if len(kinds) > 1:
        raise BagError(f"bag {source}: holds mcap and sqlite3 files, must be one bag")
    folder = output or _beside(source)
    if folder.exists():
        raise BagError(f"output {folder}: exists already, must be a new folder")
    recovery = Recovery(source, folder)
    metadata = _metadata_of(source)
    try:
        with tempfile.TemporaryDirectory(dir=_existing_parent(folder)) as workspace:
            _copy_files(files, kinds.pop(), metadata, recovery, Path(workspace))
    except OSError as error:
        _remove(folder)
        raise BagError(f"bag {source}: cannot be recovered: {one_line(error)}") from error
    except BagWriteError as error:
        _remove(folder)
        raise BagError(f"output {folder}: cannot be written: {error}") from error
    if not recovery.messages:
        _remove(folder)
        raise BagError(f"bag {source}: holds no message that could be recovered")
    return recovery


def _copy_files(
    files: list[Path], storage: str, metadata: dict[str, Any], recovery: Recovery, workspace: Path
) -> None:
    bag: BagFiles | None = None
    try:
        for file in files:
            damaged = _open_damaged(file, storage, workspace)
            if bag is None:
                bag = BagFiles(recovery.output, storage=storage, compression=damaged.compression)
            elif recovery.messages:
                bag.split()
                bag.sync()
            _copy_messages(damaged, file.stat().st_size, bag, metadata, recovery)
            recovery.damage[file.name] = damaged.damage
        if bag is not None:
            bag.close(_custom_data(metadata, recovery))
    finally:
        if bag is not None:
            bag.abandon()


def _copy_messages(
    damaged: DamagedFile, size: int, bag: BagFiles, metadata: dict[str, Any], recovery: Recovery
) -> None:
    by_message = str(metadata.get("compression_mode", "")).lower() == "message"
    places = {(topic.name, topic.message_type): n for n, topic in enumerate(bag.topics)}
    numbers = []
    for topic in damaged.topics:
        key = topic.name, topic.message_type
        if key not in places:
            places[key] = bag.add_topic(topic)
        numbers.append(places[key])
    limit = allowed_size(size)
    for stored in _batches(damaged.messages()):
        batch = _decompressed(stored, limit, damaged.damage) if by_message else stored
        limit -= sum(len(message.data) for message in batch) if by_message else 0
        bag.append([message._replace(topic=numbers[message.topic]) for message in batch])
        bag.commit()
        for message in batch:
            recovery.messages[damaged.topics[message.topic].name] += 1
            recovery.start = min(recovery.start, message.received)
            recovery.end = max(recovery.end, message.received)


def _open_damaged(file: Path, storage: str, workspace: Path) -> DamagedFile:
    if file.suffix == COMPRESSED_SUFFIX:
        plain = workspace / file.stem
        with file.open("rb") as packed, plain.open("wb") as target:
            _unpack(packed, target, allowed_size(file.stat().st_size))
        file = plain
        workspace /= "copy"
        workspace.mkdir(exist_ok=True)
    return DamagedMcapFile(file) if storage == "mcap" else DamagedSqliteFile(file, workspace)


def _unpack(packed: Any, target: Any, limit: int) -> None:
    with zstandard.ZstdDecompressor().stream_reader(packed) as reader:
        try:
            while limit > 0 and (piece := reader.read(min(PIECE, limit))):
                target.write(piece)
                limit -= len(piece)
        except zstandard.ZstdError:
            # The file ends here for the recovery, which tells what it misses.
            return


def _batches(messages: Iterator[SerializedMessage]) -> Iterator[list[SerializedMessage]]:
    batch: list[SerializedMessage] = []
    for message in messages:
        batch.append(message)
        if len(batch) == _BATCH:
            yield batch
            batch = []
    yield batch


def _decompressed(
    batch: list[SerializedMessage], limit: int, damage: Damage
) -> list[SerializedMessage]:
    plain = []
    for message in batch:
        data = decompressed_zstd(message.data, min(limit, LARGEST_CHUNK))
        limit -= len(data)
        if data:
            plain.append(message._replace(data=data))
        else:
            damage.note("a compressed message is damaged", len(message.data))
    return plain


def _custom_data(metadata: dict[str, Any], recovery: Recovery) -> dict[str, str]:
    known = metadata.get("custom_data")
    kept = known if isinstance(known, dict) else {}
    return {
        **{
            str(key): str(value)
            for key, value in kept.items()
            if key not in UNFINISHED and not str(key).startswith(PREFIX)
        },
        "recovered_from": recovery.source.name,
        "bytes_not_understood": str(sum(one.byte_count for one in recovery.damage.values())),
    }


def _files_of(source: Path) -> list[Path]:
    try:
        if source.is_dir():
            found = {file.name: file for file in source.iterdir() if _is_bag_file(file)}
        elif source.exists():
            if not _is_bag_file(source):
                raise BagError(f"bag {source}: must be a bag folder, a .mcap or a .db3 file")
            found = {source.name: source}
        else:
            raise BagError(f"bag {source}: does not exist")
    except OSError as error:
        raise BagError(f"bag {source}: cannot be read: {error.strerror or error}") from error
    # A compressed file beside its original was being written when the recorder died.
    files = [file for name, file in found.items() if name.removesuffix(COMPRESSED_SUFFIX) == name]
    names = {file.name for file in files}
    files += [
        file for name, file in found.items() if name.removesuffix(COMPRESSED_SUFFIX) not in names
    ]
    if not files:
        raise BagError(f"bag {source}: holds no .mcap and no .db3 file")
    return sorted(files, key=_place)


def _is_bag_file(file: Path) -> bool:
    return file.is_file() and _plain_suffix(file) in STORAGE_OF_SUFFIX


def _plain_suffix(file: Path) -> str:
    return Path(file.name.removesuffix(COMPRESSED_SUFFIX)).suffix


def _place(file: Path) -> tuple[list[int], str]:
    """Sort key: bag_10 stands behind bag_9."""
    numbers = re.findall(r"\d+", file.name.partition(".")[0])
    return [int(number) for number in numbers[-1:]], file.name


def _beside(source: Path) -> Path:
    resolved = real_path(source)
    name = resolved.name
    if source.is_file():
        name = name.removesuffix(COMPRESSED_SUFFIX)
        name = Path(name).stem
    return resolved.with_name(f"{name}_recovered")


def _existing_parent(folder: Path) -> Path:
    parent = folder.absolute().parent
    while not parent.exists():
        parent = parent.parent
    return parent


def _metadata_of(source: Path) -> dict[str, Any]:
    path = (source if source.is_dir() else source.parent) / METADATA_FILE
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
        information = document["rosbag2_bagfile_information"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError, yaml.YAMLError):
        # The files say nearly everything themselves; that is what recovery is for.
        return {}
    return information if isinstance(information, dict) else {}


def _remove(folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
