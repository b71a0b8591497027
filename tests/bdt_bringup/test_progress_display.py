"""The line that shows how far a run has come."""

import io
import math
from types import SimpleNamespace

import pytest

from bdt_bringup.loop_state import DEGRADED, OK, LoopState
from bdt_bringup.progress_display import ProgressDisplay, progress_line


class Terminal(io.StringIO):
    """Standard error that is, or is not, a terminal."""

    def __init__(self, terminal):
        super().__init__()
        self.terminal = terminal

    def isatty(self):
        return self.terminal


WELL = LoopState(OK, "", "well")


def monitor(time, gap=None, dead_zone=None, factor=None, state=WELL):
    return SimpleNamespace(
        simulated_time=time,
        gap=gap,
        dead_zone=dead_zone,
        state=state,
        real_time_factor=lambda: factor,
    )


def test_what_is_wrong_with_the_loop_stands_at_the_end_once_it_runs():
    late = LoopState(DEGRADED, "twin", "late")
    assert progress_line("x", 2.0, monitor(1.0, state=late)).endswith("1.0 s  degraded: twin: late")
    assert "degraded" not in progress_line("x", 2.0, monitor(0.0, state=late))


def test_before_anything_is_heard_the_line_shows_the_start():
    assert progress_line("paper", 12.0, monitor(0.0)) == f"paper [{'.' * 24}]  t =    0.0 s"


def test_what_was_heard_stands_beside_the_bar():
    line = progress_line("paper", 12.0, monitor(6.0, math.radians(3.0), 1e-5, 8.25))
    assert line == (
        f"paper [{'#' * 12}{'.' * 12}]  t =    6.0 s  8.2 x real time  gap 3.00 deg  "
        "dead zone 10.0 um"
    )


def test_the_clock_may_pass_the_end_but_the_bar_does_not():
    assert progress_line("x", 2.0, monitor(2.5)).startswith(f"x [{'#' * 24}]  t =    2.0 s")


@pytest.mark.parametrize("terminal", [True, False])
def test_a_terminal_gets_every_state_and_a_file_the_last_one(monkeypatch, terminal):
    written = Terminal(terminal)
    monkeypatch.setattr("sys.stderr", written)
    with ProgressDisplay("run", 10.0) as display:
        display.show(monitor(1.0))
        display.show(monitor(9.0))
    text = written.getvalue()
    assert "t =    9.0 s" in text
    assert ("t =    1.0 s" in text) is terminal
    assert text.endswith("\n")
    assert text.count("\n") == 1
