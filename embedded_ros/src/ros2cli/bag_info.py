"""``ros2 bag info``: what a bag holds."""

import argparse
import datetime as dt
from pathlib import Path
from typing import Any

import yaml

from ros2cli.bag_reading import open_bag

__all__ = ["info"]

_NANOSECONDS = 1_000_000_000
_FIRST_COLUMN = 19


def info(arguments: argparse.Namespace) -> None:
    """``bag info``."""
    path = Path(arguments.bag_path)
    with open_bag(path, arguments.storage) as reader:
        if arguments.topic_name:
            for connection in reader.connections:
                print(connection.topic)
            return
        rows = _rows(path, reader)
    print()
    for title, lines in rows:
        print(f"{title:<{_FIRST_COLUMN}}" + f"\n{'':{_FIRST_COLUMN}}".join(lines or [""]))
    # Service events are recorded with service introspection, which rclpy here does not have.
    print(f"{'Service:':<{_FIRST_COLUMN}}0\nService information: ")


def _rows(path: Path, reader: Any) -> list[tuple[str, list[str]]]:
    """Titles, and the lines beside each."""
    files, storage = _files(path)
    # A bag without messages starts at the end of time, as in Jazzy.
    start, duration = reader.start_time, max(reader.duration - 1, 0)
    topics = [
        f"Topic: {each.topic} | Type: {each.msgtype} | Count: {each.msgcount} | "
        f"Serialization Format: {each.ext.serialization_format}"
        for each in reader.connections
    ]
    return [
        ("Files:", files),
        ("Bag size:", [_size_text(_size(path))]),
        ("Storage id:", [storage]),
        ("ROS Distro:", [reader.ros_distro or "unknown"]),
        ("Duration:", [f"{_seconds_text(duration)}s"]),
        ("Start:", [_time_text(start)]),
        ("End:", [_time_text(start + duration)]),
        ("Messages:", [str(reader.message_count)]),
        ("Topic information:", topics),
    ]


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
