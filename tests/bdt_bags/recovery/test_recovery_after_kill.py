"""A recorder killed at any moment loses at most the last second, and nothing in between."""

import contextlib
import json
import os
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import pytest
from rosbags.rosbag2 import Reader

from bdt_bags.reading.bag_reader import BagError
from bdt_bags.recovery.recover_bag import recover_bag

pytestmark = pytest.mark.real_time

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
"""What may be lost: messages younger than this [s] at the moment of the kill, and than the time
for which the machine keeps a process from getting the processor or from writing a byte."""


@pytest.fixture(scope="module")
def writers():
    from importlib.util import module_from_spec, spec_from_file_location

    spec = spec_from_file_location("counting_writers", WRITERS)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


SLOW_SYNC = """
#define _GNU_SOURCE
#include <dlfcn.h>
#include <unistd.h>
static int later(const char *name, int file) {
    usleep(400000);
    return ((int (*)(int))dlsym(RTLD_NEXT, name))(file);
}
int fsync(int file) { return later("fsync", file); }
int fdatasync(int file) { return later("fdatasync", file); }
"""


@pytest.fixture(scope="module")
def slow_disk(tmp_path_factory):
    """Return the environment of a process whose disk takes 0.4 s for each sync."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("needs a C compiler")
    folder = tmp_path_factory.mktemp("slow")
    (folder / "slow.c").write_text(SLOW_SYNC)
    command = [compiler, "-shared", "-fPIC", "-o", folder / "slow.so", folder / "slow.c", "-ldl"]
    subprocess.run(command, check=True)
    return {"LD_PRELOAD": str(folder / "slow.so")}


def test_all_that_was_taken_a_second_before_the_kill_is_recovered_byte_for_byte(tmp_path, writers):
    kill_and_recover(tmp_path, writers, KILLS_OF_EACH, {})


def test_a_kill_costs_no_more_when_the_disk_is_slow(tmp_path, writers, slow_disk):
    """Syncs are for power cuts; what the system was given it keeps without them."""
    kill_and_recover(tmp_path, writers, KILLS_OF_EACH // 2, slow_disk)


def kill_and_recover(folder, writers, kills, environment):
    """Kill writers and compare what is recovered with what they had taken long enough before.

    Long enough is :data:`PROMISE` and the time for which the machine let a process of this kind
    wait, as such a process has measured it beside its writer.
    """
    command = [sys.executable, WRITERS, folder, "1", str(kills), *KINDS]
    done = subprocess.run(
        command,
        check=False,
        capture_output=True,
        text=True,
        timeout=300,
        env=os.environ | environment,
    )
    assert done.returncode == 0, done.stderr
    killed = json.loads(done.stdout)
    assert len(killed) == kills * len(KINDS)
    required_total = 0
    for name, moment in killed.items():
        stall = writers.stall(folder / f"{name}.stall", moment)
        times = struct.iter_unpack("<q", (folder / f"{name}.times").read_bytes())
        latest = moment - PROMISE * 1e9 - stall
        required = sum(0 < time < latest for (time,) in times)
        before = contents_of(folder / name)
        numbers = []
        # Nothing is left where the kill came before the first commit.
        with contextlib.suppress(BagError):
            numbers = read_numbers(recover_bag(folder / name).output, writers)
        assert numbers == list(range(len(numbers)))
        told = f"{name}: {len(numbers)} of {required}, stall {stall / 1e9:.3f} s"
        assert len(numbers) >= required, told
        assert contents_of(folder / name) == before
        required_total += required
    # Otherwise the processes were too slow to say anything.
    assert required_total > 10 * len(killed)


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
