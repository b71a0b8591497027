"""A re-estimation in words and as a table."""

from dataclasses import replace

import pytest

from bdt_analysis.metrics.gap_estimates import GapEstimatesSummary
from bdt_analysis.metrics.re_estimation_summary import ReEstimationSummary
from bdt_analysis.pages.re_estimation_report import (
    re_estimation_lines,
    re_estimation_table,
)


@pytest.fixture
def summary():
    return ReEstimationSummary(
        estimates=119,
        rms_error_deg=0.1234,
        worst_error_deg=0.5,
        coverage_95_percent=93.75,
        estimator="output_error",
        settings={"output_error.window": 10.0, "estimator.window": 4.0},
        recorded_settings={"motor.resistance": 1.5},
        without_effect=("estimator.window",),
        sampling_rate_hz=5000.0,
        kept=2,
        kept_reason="the lead screw does not move",
        rejected=3,
        rejected_reason="the batch is empty",
        window_ms=18.72,
        live=GapEstimatesSummary(467, 1.5, 3.25, None),
    )


def test_the_live_twin_stands_in_the_same_line(summary):
    assert re_estimation_lines(summary) == [
        (
            "re-estimated (output_error): 119 estimates, error 0.123 deg rms, 0.5 deg at worst, "
            "95 % intervals hold 94 %, 18.7 ms each; "
            "live: 467 estimates, error 1.5 deg rms, 3.25 deg at worst"
        ),
        "  set output_error.window = 10.0, estimator.window = 4.0",
        "  from the bag motor.resistance = 1.5",
        "  no effect on output_error: estimator.window",
        "  windows that taught nothing: 2, the first: the lead screw does not move",
        "  batches rejected: 3, the first: the batch is empty",
    ]


def test_what_is_unknown_is_left_out(summary):
    nothing = GapEstimatesSummary(0, None, None, None)
    bare = replace(
        summary,
        **vars(nothing),
        settings={},
        recorded_settings={},
        without_effect=(),
        kept_reason=None,
        rejected_reason=None,
        window_ms=None,
        live=nothing,
    )
    assert re_estimation_lines(bare) == [
        "re-estimated (output_error): 0 estimates; live: 0 estimates"
    ]


def test_the_table_sets_both_side_by_side(summary):
    table = re_estimation_table(summary)
    cells = {row.cells[0]: row.cells[1:] for row in table.rows}
    assert [column.name for column in table.columns[1:3]] == ["live", "re-estimated"]
    assert cells["estimates"] == ("467", "119", "")
    assert cells["gap error where stated, root mean square"] == ("1.5", "0.123", "deg")
    assert cells["95 % intervals that hold the true gap"] == ("", "93.8", "%")
    assert cells["telemetry batches rejected"] == ("", "3", "")
    assert "Batches rejected: 3, the first: the batch is empty." in table.note
