"""Expectations of the twin beside what happened: the newest decision before each step counts."""

from bdt_analysis.metrics.decision_check import check_decisions
from bdt_analysis.metrics.step_analysis import StepSummary
from bdt_analysis.pages.decision_table import decision_table
from bdt_bags.reading.twin_decisions import TwinDecision

FIRST = TwinDecision(3.0, "narrow", 0.6, 0.7, 2.0, 0)
BACK = TwinDecision(12.0, "eq. 9", None, None, None, 1)


def step(begin, bias=-0.3, *, cycle=False):
    return StepSummary(begin, 5e-3, 1e-6, -1.5e-5, bias, 1.9, cycle)


def test_each_step_has_the_newest_decision_before_it():
    checks = check_decisions([FIRST, BACK], [step(0.0), step(10.0), step(20.0, cycle=True)])
    assert [each.t_start_s for each in checks] == [10.0, 20.0]
    assert (checks[0].expected_bias_percent, checks[0].bias_percent) == (0.7, 0.3)
    assert (checks[0].expected_settling_s, checks[0].settling_s) == (2.0, 1.9)
    assert (checks[1].ratio, checks[1].reason, checks[1].taken_back) == (None, "eq. 9", 1)


def test_the_table_has_a_row_for_each_step_and_marks_limit_cycles():
    table = decision_table(check_decisions([FIRST], [step(10.0), step(20.0, None, cycle=True)]))
    assert [row.cells[:6] for row in table.rows] == [
        ("10", "0.6", "0.70", "0.30", "2.00", "1.90"),
        ("20", "0.6", "0.70", "", "2.00", "1.90"),
    ]
    assert [row.alarm for row in table.rows] == [False, True]


def test_without_decisions_there_is_no_table():
    assert decision_table(check_decisions([], [step(10.0)])) is None
