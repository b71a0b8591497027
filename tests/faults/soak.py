"""Runs loops under schedules of faults, one after the other; a seed or a line makes a schedule.

    python tests/faults/soak.py --count 1000 --begin 0 --results soak.txt
    python tests/faults/soak.py --schedule "2.85 step clock 0.95 0.39; 5.54 stop controller 0.76 1"

A file of results has a line for each seed; whoever runs this with it again goes on where it ended.
Exit code 1 if a schedule failed.
"""

import argparse
import os
import sys
from pathlib import Path

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS / "support"), str(TESTS / "conformance")]

os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"

from fault_schedule import line_of, schedule_from, schedule_of, shrunk  # noqa: E402
from faulted_loop import judge  # noqa: E402
from ros_domain import claim_domain  # noqa: E402


def main():
    """Run what is asked for; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--schedule", metavar="LINE", help="one schedule, as a failure prints it")
    parser.add_argument("--count", type=int, default=100, help="number of seeds")
    parser.add_argument("--begin", type=int, default=0, help="first seed")
    parser.add_argument("--results", type=Path, help="file to go on with")
    options = parser.parse_args()
    domain = claim_domain()
    if options.schedule is not None:
        verdict = judge(schedule_from(options.schedule), domain)
        print(f"{verdict.outcome}: {verdict.reason}")
        return int(verdict.outcome == "failed")
    done = results_in(options.results)
    for seed in range(options.begin, options.begin + options.count):
        if seed not in done:
            done[seed] = outcome_of(seed, domain)
            if options.results is not None:
                with options.results.open("a", encoding="utf-8") as file:
                    file.write(f"{seed} {done[seed]}\n")
    outcomes = [done[seed] for seed in range(options.begin, options.begin + options.count)]
    counts = {outcome: outcomes.count(outcome) for outcome in sorted(set(outcomes))}
    print(", ".join(f"{count} {outcome}" for outcome, count in counts.items()))
    return int("failed" in outcomes)


def results_in(path):
    """Return outcomes by seed; a line that a kill has torn counts as none."""
    if path is None or not path.exists():
        return {}
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    if lines and not lines[-1].endswith("\n"):
        lines.pop()
        path.write_text("".join(lines), encoding="utf-8")
    pairs = (line.split(maxsplit=1) for line in lines)
    return {int(seed): outcome.strip() for seed, outcome in pairs}


def outcome_of(seed, domain):
    """Judge the schedule of a seed, and tell of one that fails the shortest that does as well."""
    schedule = schedule_of(seed)
    verdict = judge(schedule, domain)
    print(f"{seed}: {line_of(schedule)}: {verdict.outcome}: {verdict.reason}", flush=True)
    if verdict.outcome == "failed":
        short = shrunk(schedule, lambda shorter: judge(shorter, domain).outcome == "failed")
        print(f'failed: python tests/faults/soak.py --schedule "{line_of(short)}"', flush=True)
    return verdict.outcome


if __name__ == "__main__":
    sys.exit(main())
