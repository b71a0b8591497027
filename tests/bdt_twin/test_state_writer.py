"""States are written beside the twin: the newest one, not too often, and the last one for sure."""

import time

import pytest

import bdt_twin.state_writer
from bdt_twin.state_file import read_state
from bdt_twin.state_writer import PERIOD, StateWriter
from bdt_twin.twin_state import TwinState

DEADLINE = 60.0


def state_of(tolerance):
    return TwinState("/controller", {}, tolerance)


def tolerance_in(path):
    stored = read_state(path, "/controller", {}, time.time(), 100.0)
    return None if stored is None else stored.state.tolerance


def wait_for(condition):
    end = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "twin.json"


@pytest.fixture
def written(monkeypatch):
    """Wall times at which states were written."""
    times = []
    write = bdt_twin.state_writer.write_state

    def note(path, state, now):
        times.append(time.monotonic())
        write(path, state, now)

    monkeypatch.setattr(bdt_twin.state_writer, "write_state", note)
    return times


def test_the_first_state_is_written_at_once_and_the_next_a_period_later(path, written):
    writer = StateWriter(path)
    writer.put(state_of(1e-6))
    wait_for(lambda: tolerance_in(path) == 1e-6)
    for number in range(2, 30):
        writer.put(state_of(number * 1e-6))
    wait_for(lambda: tolerance_in(path) == 29 * 1e-6)
    writer.close()
    assert len(written) == 2, "those in between were overtaken"
    assert written[1] - written[0] >= PERIOD


def test_the_last_state_is_written_at_the_end_without_delay(path, written):
    writer = StateWriter(path)
    writer.put(state_of(1e-6))
    wait_for(lambda: written)
    writer.put(state_of(2e-6))
    writer.close()
    assert tolerance_in(path) == 2e-6
    assert written[1] - written[0] < PERIOD


def test_a_writer_without_a_state_leaves_the_file_alone(path):
    StateWriter(path).close()
    assert not path.exists()


def test_a_disk_that_refuses_is_told_until_it_takes_a_state_again(tmp_path):
    folder = tmp_path / "gone"
    path = folder / "twin.json"
    writer = StateWriter(path)
    writer.put(state_of(1e-6))
    wait_for(lambda: writer.error)
    assert writer.error == f"{path}: cannot be written: No such file or directory"
    folder.mkdir()
    writer.put(state_of(2e-6))
    wait_for(lambda: not writer.error)
    writer.close()
    assert tolerance_in(path) == 2e-6
