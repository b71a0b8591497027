"""What the checks found, as lines and as JSON."""

from collections.abc import Sequence
from typing import Any

from bdt_driver.hardware_check.check import CheckResult, Outcome

_NAME_WIDTH = 25
_INDENT = " " * 10


def result_lines(result: CheckResult) -> list[str]:
    """Return the line of a check; a failed one has its reason and what to do below it.

    Parameters
    ----------
    result : CheckResult
        A check and how it ended.
    """
    text = f"({result.text})" if result.outcome is Outcome.SKIPPED else result.text
    lines = [f"{result.outcome:8}  {result.check.name:{_NAME_WIDTH}}  {text}".rstrip()]
    if result.outcome is Outcome.FAILED:
        lines += [
            f"{_INDENT}why: {result.check.reason}",
            f"{_INDENT}do:  {result.check.advice}",
        ]
    return lines


def summary_line(results: Sequence[CheckResult]) -> str:
    """Return how many checks ended how."""
    counts = (f"{_count(results, outcome)} {outcome}" for outcome in Outcome)
    return ", ".join(counts)


def as_json(results: Sequence[CheckResult]) -> dict[str, Any]:
    """Return the results as what JSON can hold."""
    return {
        **{str(outcome): _count(results, outcome) for outcome in Outcome},
        "checks": [
            {
                "name": result.check.name,
                "outcome": str(result.outcome),
                "text": result.text,
                "reason": result.check.reason,
                "advice": result.check.advice,
            }
            for result in results
        ],
    }


def _count(results: Sequence[CheckResult], outcome: Outcome) -> int:
    return sum(result.outcome is outcome for result in results)
