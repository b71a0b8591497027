"""What processes cost, compared with what this process knows of itself and its children."""

import mmap
import os
import subprocess
import sys

import pytest

from bdt_live.measuring.process_load import (
    growth,
    memory_of,
    processor_time_of,
    tree_of,
    words_of,
)

WAIT = "import sys; print('ready', flush=True); sys.stdin.read()"


@pytest.fixture
def child():
    process = subprocess.Popen(
        [sys.executable, "-c", WAIT], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    process.stdout.readline()
    yield process
    process.communicate()


def test_what_a_process_has_started_belongs_to_its_tree(child):
    assert child.pid in tree_of(os.getpid())
    assert tree_of(child.pid) == [child.pid]


def test_a_process_is_known_by_its_words_until_it_has_ended(child):
    assert words_of(child.pid) == [sys.executable, "-c", WAIT]
    child.communicate()
    assert words_of(child.pid) == []


def test_memory_that_is_filled_is_counted():
    size = 32 << 20
    # Memory of its own, not what the interpreter has left of something else.
    with mmap.mmap(-1, size) as memory:
        before = memory_of([os.getpid()])
        memory.write(bytes(size))
        assert memory_of([os.getpid()]) - before > 0.9 * size


def test_a_process_that_has_ended_holds_nothing(child):
    child.communicate()
    assert memory_of([child.pid]) == 0


def test_the_processor_s_time_is_that_of_the_process():
    times = os.times()
    assert processor_time_of(os.getpid()) == pytest.approx(times.user + times.system, abs=0.1)


@pytest.mark.parametrize(
    ("samples", "expected"),
    [
        ([100] * 8, 0.0),
        ([1, 1, 100, 100, 100, 100, 110, 110], 0.1),  # the first quarter fills up
        ([100, 100, 100, 100, 100, 100, 50, 900], 3.75),
        ([7], 0.0),
    ],
)
def test_growth_is_from_the_second_to_the_last_quarter(samples, expected):
    assert growth(samples) == pytest.approx(expected)
