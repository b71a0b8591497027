"""One run of a bag that holds several."""

from dataclasses import fields

import numpy as np
import pytest

from bdt_bags.bag_error import BagError
from bdt_bags.reading.message_runs import STRAY
from bdt_bags.reading.recording import Recording, load_recording
from bdt_bags.reading.run_selection import STRAGGLERS, run_limits
from bdt_bringup.cli import run_command
from bdt_msgs_py.topics import MEASUREMENT, TELEMETRY

PAUSE = 8.0
"""Time of reception, in run time [s], from the begin of one run to that of the next: 2 s of wall
time at the pace of the bags that the tests write."""


def after(first, second, pause=PAUSE):
    """Return the messages of a second run recorded after those of a first one."""
    both = first.without()
    both.items.extend((name, kind, t + pause, message) for name, kind, t, message in second.items)
    return both


def assert_same(found: Recording, expected: Recording) -> None:
    for field in fields(Recording):
        if field.name == "path":
            continue
        if field.name == "message_counts":  # of topics that were read
            assert found.message_counts.items() <= expected.message_counts.items()
            assert expected.message_counts.keys() - found.message_counts.keys() <= {"/clock"}
            continue
        values = [getattr(x, field.name) for x in (found, expected)]
        if field.name in ("measurements", "commands", "batches"):
            values = [x.stamps for x in values]
        np.testing.assert_equal(*values, err_msg=field.name)


@pytest.mark.parametrize("dropped", [(), (MEASUREMENT,), (TELEMETRY,)])
def test_each_run_is_what_a_bag_of_its_own_would_hold(small_loop, shortest_loop, tmp_path, dropped):
    runs = [x.without(*dropped) for x in (small_loop, shortest_loop, small_loop)]
    bag = after(after(*runs[:2]), runs[2], 2 * PAUSE).write(tmp_path / "bag")
    for number, messages in enumerate(runs, start=1):
        alone = load_recording(messages.write(tmp_path / f"{number}"))
        assert_same(load_recording(bag, run=number), alone)


def test_the_only_run_is_the_first(small_loop, tmp_path):
    bag = small_loop.write(tmp_path / "bag")
    assert_same(load_recording(bag, run=1), load_recording(bag))


def test_the_last_estimate_of_a_run_comes_after_its_last_sample(small_loop, tmp_path):
    """An initial dead zone between two runs is that of the second one."""
    first, second = small_loop.without(), small_loop.without()
    message = first.items[-1]
    first.estimate(1.98, 0.123)
    first.items[-1] = (*first.items[-1][:2], message[2] + 0.4, first.items[-1][3])
    second.dead_zone(0.0, 7e-6, initial=True, received=-3.0)
    bag = after(first, second).write(tmp_path / "bag")
    assert 0.123 in load_recording(bag, run=1).estimates[:, 1]
    found = load_recording(bag, run=2)
    assert 0.123 not in found.estimates[:, 1]
    assert found.dead_zones[0].tolist() == [0.0, 7e-6]


def test_without_a_choice_the_line_tells_how_to_choose(small_loop, shortest_loop, tmp_path, capsys):
    bag = after(small_loop, shortest_loop).write(tmp_path / "bag")
    assert run_command(["analyze", str(bag)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith("holds 2 runs, choose one with bdt analyze --run 1 to --run 2")
    assert run_command(["analyze", str(bag), "--run", "2"]) == 0
    assert (tmp_path / "bag_run_2_report" / "report.html").exists()


@pytest.mark.parametrize("dropped", [(), (MEASUREMENT,), (TELEMETRY,)])
def test_a_run_done_twice_is_two_runs_although_a_lockstep_loop_repeats_itself(
    small_loop, tmp_path, dropped
):
    messages = small_loop.without(*dropped)
    bag = after(messages, messages).write(tmp_path / "bag")
    with pytest.raises(BagError, match=r"time goes back: holds 2 runs, choose one with"):
        load_recording(bag)
    assert_same(load_recording(bag, run=1), load_recording(bag, run=2))


@pytest.mark.parametrize("number", [-1, 0, 3])
def test_a_run_that_is_not_there(small_loop, shortest_loop, tmp_path, number):
    bag = after(small_loop, shortest_loop).write(tmp_path / "bag")
    with pytest.raises(BagError, match=rf"holds 2 runs: --run {number} is none of them"):
        load_recording(bag, run=number)
    with pytest.raises(BagError, match=r"holds one run: --run 2 is none of them"):
        load_recording(small_loop.write(tmp_path / "one"), run=2)


def test_a_run_begins_with_its_first_message():
    runs = np.array([0, 0, STRAY, 1, 1, STRAY, 2])
    assert run_limits(runs, [0, 7, 14, 21, 28, 35, 42]) == [21, 42]
    assert run_limits(runs[:3], [0, 7, 14]) == []
    assert run_limits(runs[:0], []) == []


def test_stragglers_belong_to_the_run_before():
    end = 10 * STRAGGLERS
    assert run_limits(np.array([0, 0, 0, 1, 1]), [0, 1, 2, end, end + 1]) == [2 + STRAGGLERS]
