"""Every dead zone, the estimate behind it, and its delay."""

import numpy as np
import pytest

from bdt_bringup.analysis.reconfigurations import (
    reconfiguration_log,
    summarize_reconfigurations,
)
from bdt_bringup.bags.recording import load_recording
from bdt_bringup.run_signals import RunSignals

PITCH = 2e-4


def run(estimates, dead_zones) -> RunSignals:
    return RunSignals(
        telemetry=np.zeros((2, 3)),
        truth=None,
        reference=np.empty((0, 2)),
        estimates=np.array(estimates).reshape(-1, 2),
        dead_zones=np.array(dead_zones).reshape(-1, 2),
        pitch=PITCH,
    )


def test_log():
    first, by_hand, second = reconfiguration_log(
        run([[1.0, 0.3], [2.0, 0.4]], [[0.0, 0.0], [1.7, 5e-5], [2.9, PITCH * 0.4]])
    )
    assert (first.time_s, first.change_m, first.delay_s) == (0.0, None, None)
    assert by_hand.change_m == pytest.approx(5e-5)
    assert by_hand.estimate_rad is None
    assert second.estimate_time_s == 2.0
    assert second.estimate_rad == 0.4
    assert second.delay_s == pytest.approx(0.9)
    assert second.change_m == pytest.approx(PITCH * 0.4 - 5e-5)


def test_no_dead_zone():
    assert reconfiguration_log(run([[1.0, 0.3]], [])) == []


def test_summary_of_a_loop(following_bag):
    """Delay 0.5 s; update periods end 0.02 s before batches."""
    recording = load_recording(following_bag)
    found = summarize_reconfigurations(recording)
    assert found.from_estimates == recording.reconfigurations
    assert found.from_elsewhere == 0
    assert found.estimates_not_applied == len(recording.estimates) - recording.reconfigurations
    assert found.min_s == pytest.approx(0.52, abs=3e-3)
    assert found.median_s == pytest.approx(found.max_s, abs=3e-3)


def test_dead_zone_set_by_hand(small_loop, tmp_path):
    messages = small_loop.without()
    before = summarize_reconfigurations(load_recording(messages.write(tmp_path / "a")))
    messages.dead_zone(1.99, 3.3e-5)
    after = summarize_reconfigurations(load_recording(messages.write(tmp_path / "b")))
    assert (before.from_elsewhere, after.from_elsewhere) == (0, 1)
    assert before.from_estimates == after.from_estimates
