"""``ros2 bag``: record, inspect and play bags."""

import argparse
import datetime as dt
from pathlib import Path
from typing import Any

import yaml

from ros2cli import bag_play, bag_record
from ros2cli.bag_reading import add_bag_arguments, open_bag
from ros2cli.node_session import add_group

__all__ = ["add_commands"]

_NANOSECONDS = 1_000_000_000
_FIRST_COLUMN = 19


def add_commands(groups: Any) -> None:
    """Add the command to the parser."""
    verbs = add_group(groups, "bag", "Various rosbag related sub-commands")
    verb = verbs.add_parser("info", help="Print information about a bag to the screen")
    add_bag_arguments(verb)
    verb.add_argument("-t", "--topic-name", action="store_true", help="Only display topic names")
    verb.set_defaults(main=_info)
    bag_play.add_verb(verbs)
    bag_record.add_verb(verbs)


def _info(arguments: argparse.Namespace) -> None:
    path = Path(arguments.bag_path)
    with open_bag(path, arguments.storage) as reader:
        if arguments.topic_name:
            for connection in reader.connections:
                print(connection.topic)
            return
        files, storage = _files(path)
        # A bag without messages starts at the end of time, as in Jazzy.
        start, duration = reader.start_time, max(reader.duration - 1, 0)
        rows = [
            ("Files:", files or [""]),
            ("Bag size:", [_size_text(_size(path))]),
            ("Storage id:", [storage]),
            ("ROS Distro:", [reader.ros_distro or "unknown"]),
            ("Duration:", [f"{_seconds_text(duration)}s"]),
            ("Start:", [_time_text(start)]),
            ("End:", [_time_text(start + duration)]),
            ("Messages:", [str(reader.message_count)]),
            (
                "Topic information:",
                [
                    f"Topic: {connection.topic} | Type: {connection.msgtype} | "
                    f"Count: {connection.msgcount} | "
                    f"Serialization Format: {connection.ext.serialization_format}"
                    for connection in reader.connections
                ]
                or [""],
            ),
        ]
    print()
    for title, lines in rows:
        print(f"{title:<{_FIRST_COLUMN}}" + f"\n{'':{_FIRST_COLUMN}}".join(lines))
    # Service events are recorded with service introspection, which rclpy here does not have.
    print(f"{'Service:':<{_FIRST_COLUMN}}0\nService information: ")


def _files(path: Path) -> tuple[list[str], str]:
    """Storage files of a bag, and the name of the storage."""
    if path.is_file():
        return [str(path)], "mcap" if path.suffix == ".mcap" else "sqlite3"
    content = yaml.safe_load((path / "metadata.yaml").read_text(encoding="utf-8"))
    information = content["rosbag2_bagfile_information"]
    return information["relative_file_paths"], information["storage_identifier"]


def _size(path: Path) -> int:
    if path.is_file():
        return path.stat().st_size
    return sum(entry.stat().st_size for entry in path.iterdir() if entry.is_file())


def _size_text(size: float) -> str:
    units = ["B", "KiB", "MiB", "GiB", "TiB"]
    while size >= 1024 and len(units) > 1:
        size /= 1024
        units.pop(0)
    return f"{size:.{0 if units[0] == 'B' else 1}f} {units[0]}"


def _seconds_text(nanoseconds: int) -> str:
    seconds, rest = divmod(nanoseconds, _NANOSECONDS)
    return f"{seconds}.{rest:09d}"


def _time_text(nanoseconds: int) -> str:
    seconds, rest = divmod(nanoseconds, _NANOSECONDS)
    local = dt.datetime.fromtimestamp(seconds).astimezone()
    date = f"{local:%b} {local.day:2d} {local.year}"
    return f"{date} {local:%H:%M:%S}.{rest:09d} ({_seconds_text(nanoseconds)})"
