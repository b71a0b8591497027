"""A recorder killed at any moment loses at most the last second, and nothing in between."""

import contextlib
import json
import struct
import subprocess
import sys
from pathlib import Path

import pytest
from rosbags.rosbag2 import Reader

from bdt_bringup.bags.bag_reader import BagError
from bdt_bringup.recovery.recover_bag import recover_bag

WRITERS = Path(__file__).with_name("counting_writers.py")
KINDS = (
    "mcap:none:0:0",
    "mcap:zstd:0:0",
    "mcap:none:100000:0",
    "sqlite3:none:0:0",
    "sqlite3:none:0:0.7",
    "sqlite3:zstd:0:0",
)
KILLS_OF_EACH = 9
PROMISE = 1.0
"""What may be lost: messages younger than this [s] at the moment of the kill."""


@pytest.fixture(scope="module")
def writers():
    from importlib.util import module_from_spec, spec_from_file_location

    spec = spec_from_file_location("counting_writers", WRITERS)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_all_that_was_taken_a_second_before_the_kill_is_recovered_byte_for_byte(tmp_path, writers):
    command = [sys.executable, WRITERS, tmp_path, "1", str(KILLS_OF_EACH), *KINDS]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    killed = json.loads(done.stdout)
    assert len(killed) == KILLS_OF_EACH * len(KINDS) >= 50
    required_total = 0
    for name, moment in killed.items():
        times = struct.iter_unpack("<q", (tmp_path / f"{name}.times").read_bytes())
        required = sum(0 < time < moment - PROMISE * 1e9 for (time,) in times)
        before = contents_of(tmp_path / name)
        numbers = []
        # Nothing is left where the kill came before the first commit.
        with contextlib.suppress(BagError):
            numbers = read_numbers(recover_bag(tmp_path / name).output, writers)
        assert numbers == list(range(len(numbers)))
        assert len(numbers) >= required, f"{name}: {len(numbers)} of {required}"
        assert contents_of(tmp_path / name) == before
        required_total += required
    # Otherwise the processes were too slow to say anything.
    assert required_total > 100


def read_numbers(bag, writers):
    """Return the numbers of the messages of a bag in order, after comparing their content."""
    numbers = []
    with Reader(bag) as reader:
        assert sum(one.msgcount for one in reader.connections) == reader.message_count
        for connection, _, data in reader.messages():
            number = int.from_bytes(data[:8], "little")
            assert data == writers.content(number)
            assert connection.topic == writers.TOPICS[number % 2]
            numbers.append(number)
    return numbers


def contents_of(folder):
    return {file.name: file.read_bytes() for file in folder.iterdir()}
