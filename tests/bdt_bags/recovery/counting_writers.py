"""Processes that write counted messages until they are killed.

``python counting_writers.py FOLDER SEED KILLS KIND ...`` starts KILLS processes of each KIND
(``storage:compression:split_size:split_duration``), kills each at a random moment and prints the
times as JSON. A process notes the time of each message in ``FOLDER/<name>.times`` once the
writer has taken it, and in ``FOLDER/<name>.stall`` how late the machine is, see `note_stalls`.
"""

import json
import mmap
import os
import signal
import struct
import sys
import threading
import time
from pathlib import Path

import numpy as np

import bdt_bags.writing.file_compression
import bdt_bags.writing.mcap_file  # noqa: F401 - before the fork, once for all processes
from bdt_bags.writing.background_writer import BackgroundWriter
from bdt_bags.writing.bag_files import BagFiles
from bdt_bags.writing.topic_metadata import topic_metadata

TOPICS = ("/count", "/again")
DESCRIBED = [topic_metadata(name, "std_msgs/msg/String", "") for name in TOPICS]
PERIOD = 5e-3
PROBE_PERIOD = 0.05
LONGEST = 3.0
"""Nothing is killed later than this after its first message [s]."""


def content(number: int) -> bytes:
    """Return the message with a number, between 8 and 1500 bytes."""
    return (number.to_bytes(8, "little") * 200)[: 8 + number * 7919 % 1492]


def note_stalls(file: Path) -> None:
    """Do now and then what a writer depends on: get the processor, and hand a byte to the system.

    The file holds when that is due next and how late it was at worst [ns].
    """
    with file.open("r+b") as notes, mmap.mmap(notes.fileno(), 0) as shared:
        probe = os.open(file.with_suffix(".probe"), os.O_WRONLY | os.O_CREAT)
        worst = 0
        while True:
            due = time.monotonic_ns() + round(PROBE_PERIOD * 1e9)
            struct.pack_into("<qq", shared, 0, due, worst)
            time.sleep(PROBE_PERIOD)
            os.pwrite(probe, b".", 0)
            worst = max(worst, time.monotonic_ns() - due)


def stall(file: Path, moment: int) -> int:
    """Return how late the machine was at worst until a moment [ns]."""
    due, worst = struct.unpack("<qq", file.read_bytes())
    return max(worst, moment - due if due else 0)


def write_until_killed(bag: Path, kind: str, times: Path) -> None:
    stalls = times.with_suffix(".stall")
    threading.Thread(target=note_stalls, args=[stalls], daemon=True).start()
    storage, compression, split_size, split_duration = kind.split(":")
    files = BagFiles(
        bag,
        storage=storage,
        compression=compression,
        split_size=int(split_size),
        split_duration=float(split_duration),
    )
    writer = BackgroundWriter(files, print)
    topics = [writer.add_topic(topic) for topic in DESCRIBED]
    with times.open("r+b") as file, mmap.mmap(file.fileno(), 0) as shared:
        for number in range(len(shared) // 8):
            writer.write(topics[number % 2], time.time_ns(), content(number))
            struct.pack_into("<q", shared, 8 * number, time.monotonic_ns())
            time.sleep(PERIOD)


def main() -> None:
    folder, seed, kills, *kinds = sys.argv[1:]
    moments = np.random.default_rng(int(seed))
    started = []
    for kind in kinds:
        for _ in range(int(kills)):
            name = f"bag{len(started)}"
            times = Path(folder) / f"{name}.times"
            times.write_bytes(bytes(8 * round(2 * LONGEST / PERIOD)))
            times.with_suffix(".stall").write_bytes(bytes(16))
            pid = os.fork()
            if pid == 0:
                write_until_killed(Path(folder) / name, kind, times)
                os._exit(1)
            started.append((round(1e9 * moments.uniform(0.3, LONGEST)), pid, name))
    killed = {}
    while len(killed) < len(started):
        for age, pid, name in started:
            if name not in killed and is_older(Path(folder) / f"{name}.times", age):
                killed[name] = time.monotonic_ns()
                os.kill(pid, signal.SIGKILL)
                assert os.WIFSIGNALED(os.waitpid(pid, 0)[1])
        time.sleep(PERIOD)
    print(json.dumps(killed))


def is_older(times: Path, age: int) -> bool:
    """Tell whether the first message of a process was written more than `age` [ns] ago."""
    with times.open("rb") as file:
        (first,) = struct.unpack("<q", file.read(8))
    return 0 < first < time.monotonic_ns() - age


if __name__ == "__main__":
    main()
