"""The file ``metadata.yaml`` of a bag, version 9, as ROS 2 Jazzy has it."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from bdt_bags.bag_format import METADATA_FILE, NEWEST_VERSION
from bdt_bags.writing.topic_metadata import BagWriteError, TopicMetadata
from bdt_msgs_py.folder_sync import sync_folder

UNFINISHED = {"recording": "unfinished"}
"""What metadata.yaml says of itself while a bag is being written."""
_NEVER = 2**63 - 1


@dataclass
class FileInformation:
    """One file of a bag: its name, times of its first and last message [ns], their number."""

    name: str
    start: int = _NEVER
    end: int = 0
    message_count: int = 0

    def add(self, received: int) -> None:
        """Count a message received at a time [ns]."""
        self.start = min(self.start, received)
        self.end = max(self.end, received)
        self.message_count += 1


def describe_bag(
    storage: str,
    topics: Sequence[TopicMetadata],
    counts: Mapping[int, int],
    spans: Sequence[FileInformation],
    custom_data: Mapping[str, str],
    *,
    file_compression: str = "",
) -> dict[str, Any]:
    """Return what stands in ``metadata.yaml`` below ``rosbag2_bagfile_information``.

    Parameters
    ----------
    storage : str
        ``mcap`` or ``sqlite3``.
    topics : sequence of TopicMetadata
        All topics, also those without messages.
    counts : mapping of int to int
        Number of messages by the topic's place in `topics`.
    spans : sequence of FileInformation
        The files in the order of recording.
    custom_data : mapping of str to str
        What the recorder adds.
    file_compression : str
        Format in which whole files are compressed; "" for none. The chunks of an mcap are not
        meant: their compression is an affair of that storage.
    """
    start = min((span.start for span in spans), default=_NEVER)
    end = max((span.end for span in spans), default=0)
    return {
        "version": NEWEST_VERSION,
        "storage_identifier": storage,
        "duration": {"nanoseconds": max(end - start, 0)},
        "starting_time": {"nanoseconds_since_epoch": start},
        "message_count": sum(span.message_count for span in spans),
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": topic.name,
                    "type": topic.message_type,
                    "serialization_format": topic.serialization_format,
                    "offered_qos_profiles": _profiles(topic.offered_qos),
                    "type_description_hash": topic.type_hash,
                },
                "message_count": counts.get(number, 0),
            }
            for number, topic in enumerate(topics)
        ],
        "compression_format": file_compression,
        "compression_mode": "FILE" if file_compression else "",
        "relative_file_paths": [span.name for span in spans],
        "files": [
            {
                "path": span.name,
                "starting_time": {"nanoseconds_since_epoch": span.start},
                "duration": {"nanoseconds": max(span.end - span.start, 0)},
                "message_count": span.message_count,
            }
            for span in spans
        ],
        "custom_data": dict(custom_data) or None,
        "ros_distro": "jazzy",
    }


def metadata_text(information: Mapping[str, Any]) -> str:
    """Return a description as YAML."""
    return yaml.safe_dump(dict(information), sort_keys=False, width=1000)


def write_metadata(folder: Path, information: Mapping[str, Any]) -> None:
    """Replace ``metadata.yaml``: after a power cut there is the old or the new one, whole.

    Raises
    ------
    BagWriteError
        If the disk refuses; the old file is still there.
    """
    text = metadata_text({"rosbag2_bagfile_information": dict(information)})
    # A name that ends like a bag's file or metadata would mislead whoever looks into the folder.
    draft = folder / f".{METADATA_FILE}.draft"
    try:
        with draft.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(folder / METADATA_FILE)
        sync_folder(folder)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise BagWriteError(error.strerror) from error


def _profiles(text: str) -> list[Any]:
    try:
        profiles = yaml.safe_load(text)
    except yaml.YAMLError:
        # Of a damaged bag; without profiles rosbag2 plays with its defaults.
        return []
    return profiles if isinstance(profiles, list) else []
