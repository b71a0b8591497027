"""Small bags to be damaged."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bdt_bags.writing.bag_files import BagFiles
from bdt_bags.writing.topic_metadata import SerializedMessage, topic_metadata

COMMITS = 5
COMMIT_MESSAGES = 6


def small_message(number: int) -> SerializedMessage:
    """Return a message with a number, on one of two topics."""
    return SerializedMessage(
        number % 2, 1000 + number, 1000 + number, number.to_bytes(8, "little") * 5
    )


@pytest.fixture(scope="session")
def small_messages() -> list[SerializedMessage]:
    """Return the messages of a small bag."""
    return [small_message(number) for number in range(COMMITS * COMMIT_MESSAGES)]


@pytest.fixture
def small_bag(tmp_path: Path, small_messages: list[SerializedMessage]) -> Callable[..., Path]:
    """Return a function that writes a small bag and returns its folder."""

    def write(name: str = "bag", **options: Any) -> Path:
        bag = BagFiles(tmp_path / name, **options)
        bag.add_topic(topic_metadata("/even", "std_msgs/msg/String", ""))
        bag.add_topic(topic_metadata("/odd", "std_msgs/msg/Header", ""))
        for begin in range(0, len(small_messages), COMMIT_MESSAGES):
            bag.append(small_messages[begin : begin + COMMIT_MESSAGES])
            bag.commit()
        bag.close({"messages_dropped": "2"})
        return tmp_path / name

    return write
