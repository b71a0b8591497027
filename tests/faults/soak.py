"""Runs loops under schedules of faults; a seed or a line makes a schedule.

    python tests/faults/soak.py --count 1000 --begin 0 --results soak.txt --jobs 4
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
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from itertools import islice
from multiprocessing import active_children, get_context
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
    parser.add_argument("--jobs", type=int, default=1, help="loops at the same time")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    if options.schedule is not None:
        claim()
        verdict = judge(options.machine, schedule_from(options.schedule))
        print(f"{verdict.outcome}: {verdict.reason}")
        return int(verdict.outcome == "failed")
    done = results_in(options.results)
    seeds = range(options.begin, options.begin + options.count)
    missing = [seed for seed in seeds if seed not in done]
    for seed, outcome, told in judged(missing, options.machine, options.jobs):
        done[seed] = outcome
        if options.results is not None:
            with options.results.open("a", encoding="utf-8") as file:
                file.write(f"{seed} {outcome}\n")
        print(told, flush=True)
    outcomes = [done[seed] for seed in seeds]
    counts = {outcome: outcomes.count(outcome) for outcome in sorted(set(outcomes))}
    print(", ".join(f"{count} {outcome}" for outcome, count in counts.items()))
    return int("failed" in outcomes)


def claim():
    """Give this process a ROS domain, and let it end its loop when it is told to end."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    os.environ["ROS_DOMAIN_ID"] = str(claim_domain())


def judged(seeds, on_machine, jobs):
    """Yield seed, outcome and what is to be told of each, as they come."""
    waiting = iter(seeds)
    with ProcessPoolExecutor(jobs, get_context("spawn"), claim) as pool:

        def begin(count):
            return {pool.submit(outcome_of, one, on_machine) for one in islice(waiting, count)}

        # None is begun before one has ended, so that none is to be begun when this is interrupted.
        running = begin(jobs)
        try:
            while running:
                ended, running = wait(running, return_when=FIRST_COMPLETED)
                running |= begin(len(ended))
                for one in ended:
                    yield one.result()
        except BaseException:
            for worker in active_children():
                worker.terminate()
            raise


def judge(on_machine, schedule):
    """Run a loop with a plant in lockstep, or with an emulated machine; return the verdict."""
    domain = int(os.environ["ROS_DOMAIN_ID"])
    if not on_machine:
        return LockstepLoop(schedule, domain).judge()
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


def outcome_of(seed, on_machine):
    """Judge the schedule of a seed; return seed, outcome and what is to be told.

    Of one that fails, the shortest one is told that fails as well.
    """
    schedule = schedule_of(seed)
    try:
        verdict = judge(on_machine, schedule)
        told = f"{seed}: {line_of(schedule)}: {verdict.outcome}: {verdict.reason}"
        if verdict.outcome == "failed":
            short = shrunk(schedule, lambda shorter: judge(on_machine, shorter).outcome == "failed")
            told += f'\nfailed: python tests/faults/soak.py --schedule "{line_of(short)}"'
    except KeyboardInterrupt:
        # The pool would take this for a result, and this process would wait for the next schedule.
        os._exit(130)
    return seed, verdict.outcome, told


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
