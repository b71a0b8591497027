"""Runs loops under schedules of faults, one after the other; a seed or a line makes a schedule.

    python tests/faults/soak.py --count 1000 --begin 0 --results soak.txt
    python tests/faults/soak.py --schedule "2.85 step clock 0.95 0.39; 5.54 stop controller 0.76 1"
    python tests/faults/soak.py --machine --count 100 --results machine.txt

A file of results has a line for each seed; whoever runs this with it again goes on where it ended.
Exit code 1 if a schedule failed.
"""

import argparse
import os
import signal
import sys
import tempfile
from functools import partial
from pathlib import Path

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS / "support"), str(TESTS / "conformance"), str(TESTS.parent)]

os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"

from fault_schedule import line_of, schedule_from, schedule_of, shrunk  # noqa: E402
from lockstep_loop import LockstepLoop  # noqa: E402
from machine_loop import judge_machine  # noqa: E402
from ros_domain import claim_domain  # noqa: E402


def main():
    """Run what is asked for; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--schedule", metavar="LINE", help="one schedule, as a failure prints it")
    parser.add_argument("--count", type=int, default=100, help="number of seeds")
    parser.add_argument("--begin", type=int, default=0, help="first seed")
    parser.add_argument(
        "--machine",
        action="store_true",
        help="an emulated machine in real time in place of the plant in lockstep",
    )
    parser.add_argument("--results", type=Path, help="file to go on with")
    options = parser.parse_args()
    # However it is ended, it ends the loop that it has started.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    judge = partial(judge_in_real_time if options.machine else judge_in_lockstep, claim_domain())
    if options.schedule is not None:
        verdict = judge(schedule_from(options.schedule))
        print(f"{verdict.outcome}: {verdict.reason}")
        return int(verdict.outcome == "failed")
    done = results_in(options.results)
    for seed in range(options.begin, options.begin + options.count):
        if seed not in done:
            done[seed] = outcome_of(seed, judge)
            if options.results is not None:
                with options.results.open("a", encoding="utf-8") as file:
                    file.write(f"{seed} {done[seed]}\n")
    outcomes = [done[seed] for seed in range(options.begin, options.begin + options.count)]
    counts = {outcome: outcomes.count(outcome) for outcome in sorted(set(outcomes))}
    print(", ".join(f"{count} {outcome}" for outcome, count in counts.items()))
    return int("failed" in outcomes)


def judge_in_lockstep(domain, schedule):
    """Run the loop with a plant in lockstep and return the verdict."""
    return LockstepLoop(schedule, domain).judge()


def judge_in_real_time(domain, schedule):
    """Run the loop with an emulated machine and return the verdict."""
    with tempfile.TemporaryDirectory() as folder:
        return judge_machine(schedule, domain, Path(folder))


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


def outcome_of(seed, judge):
    """Judge the schedule of a seed, and tell of one that fails the shortest that does as well."""
    schedule = schedule_of(seed)
    verdict = judge(schedule)
    print(f"{seed}: {line_of(schedule)}: {verdict.outcome}: {verdict.reason}", flush=True)
    if verdict.outcome == "failed":
        short = shrunk(schedule, lambda shorter: judge(shorter).outcome == "failed")
        print(f'failed: python tests/faults/soak.py --schedule "{line_of(short)}"', flush=True)
    return verdict.outcome


if __name__ == "__main__":
    sys.exit(main())
