"""The report: a line for each check, reason and advice for those that failed."""

from bdt_driver.hardware_check.check import Check, CheckResult, Outcome
from bdt_driver.hardware_check.report import as_json, result_lines, summary_line

CHECK = Check("stops", lambda stand: "", "It must.", "Make it.")
OK = CheckResult(CHECK, Outcome.OK, "after 2 ms")
FAILED = CheckResult(CHECK, Outcome.FAILED, "never")
SKIPPED = CheckResult(CHECK, Outcome.SKIPPED, "needs moves")


def test_what_is_ok_or_skipped_is_one_line():
    assert result_lines(OK) == ["ok        stops                      after 2 ms"]
    assert result_lines(SKIPPED) == ["skipped   stops                      (needs moves)"]


def test_what_failed_says_why_and_what_to_do():
    assert result_lines(FAILED) == [
        "failed    stops                      never",
        "          why: It must.",
        "          do:  Make it.",
    ]


def test_the_summary_counts():
    assert summary_line([OK, OK, FAILED]) == "2 ok, 1 failed, 0 skipped"


def test_json_has_all_of_it():
    found = as_json([OK, SKIPPED])
    assert (found["ok"], found["failed"], found["skipped"]) == (1, 0, 1)
    assert found["checks"][1] == {
        "name": "stops",
        "outcome": "skipped",
        "text": "needs moves",
        "reason": "It must.",
        "advice": "Make it.",
    }
