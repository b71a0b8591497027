"""Tries the twin on machines that share no equation with it; prints a table in Markdown.

    python tests/machines/evaluate.py --results rows.jsonl
    python tests/machines/evaluate.py --kind everyday --count 26 --kind unknown --count 60 --jobs 2

Without a kind it runs each effect by itself in the paper's scenario. A file of results has a line
for each machine; whoever runs this with it again goes on where it ended.
"""

import argparse
import json
import math
import sys
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS / "support")]

from drawn_machines import KINDS, ROWS, drawn, named  # noqa: E402
from machine_with_twin import (  # noqa: E402
    BATCH,
    HOLD,
    SAMPLING_RATE,
    is_pushed,
    run_with_twin,
    steps_with_true_gap,
)

HEADER = (
    "| machines | answered | rms, worst error | 95 % interval holds | steps in a limit cycle "
    "(avoidable; with the true gap) | pushed at the end | per estimate, mean and largest |\n"
    "|---|---|---|---|---|---|---|"
)


def main():
    """Run what is asked for and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kind", action="append", choices=sorted(KINDS), default=[])
    parser.add_argument("--count", type=int, action="append", default=[], help="of each kind")
    parser.add_argument("--begin", type=int, default=0, help="first seed")
    parser.add_argument("--results", type=Path, help="file to go on with")
    parser.add_argument("--jobs", type=int, default=1, help="machines at the same time")
    options = parser.parse_args()
    if len(options.count) != len(options.kind):
        parser.error("each --kind needs a --count")
    wanted = [
        (kind, seed)
        for kind, count in zip(options.kind, options.count, strict=True)
        for seed in range(options.begin, options.begin + count)
    ] or [(name, options.begin) for name in ROWS]
    done = results_in(options.results)
    missing = [one for one in wanted if one not in done]
    with ProcessPoolExecutor(options.jobs, get_context("spawn"), compile_everything) as pool:
        running = {
            pool.submit(result_of, *one, is_drawn=bool(options.kind)): one for one in missing
        }
        for ended in as_completed(running):
            one = running[ended]
            done[one] = ended.result()
            if options.results is not None:
                with options.results.open("a", encoding="utf-8") as file:
                    file.write(json.dumps([*one, done[one]]) + "\n")
            print(row(f"{one[0]} {one[1]}", [done[one]]), file=sys.stderr, flush=True)
    print(HEADER)
    for name in dict(wanted):
        found = [done[one] for one in wanted if one[0] == name]
        print(row(name if len(found) == 1 else f"{len(found)} {name}", found))
    return 0


def compile_everything():
    """Let this process compile what it needs, so that no estimate's time has it."""
    trial = drawn("everyday", 0)
    run_with_twin(trial.machine, replace(trial.course, gaps=trial.course.gaps[: 10 * HOLD * BATCH]))


def results_in(path):
    """Return results by name and seed."""
    if path is None or not path.exists():
        return {}
    lines = map(json.loads, path.read_text(encoding="utf-8").splitlines())
    return {(name, seed): result for name, seed, result in lines}


def result_of(name, seed, *, is_drawn):
    """Run a machine with the twin and with the true gap; return what is to be kept."""
    trial = drawn(name, seed) if is_drawn else named(name, seed)
    run = run_with_twin(*trial)
    learned = [each for each in run.estimates if each.is_known and not each.reason]
    times = np.array([each.time for each in learned])
    true = np.interp(times, np.arange(len(run.gaps)) / SAMPLING_RATE, run.gaps)
    ideal = steps_with_true_gap(*trial)
    judged = [
        (bool(one.limit_cycle), bool(best.limit_cycle), is_pushed(*trial, one))
        for one, best in zip(run.steps, ideal, strict=True)
        if one.t_start_s >= run.first_dead_zone
    ]
    return {
        "estimates": len(run.estimates),
        "times": times.tolist(),
        "errors": [each.gap - gap for each, gap in zip(learned, true, strict=True)],
        "uncertainties": [each.uncertainty for each in learned],
        "steps": judged,
        "window_times": run.window_times,
    }


def row(name, results):
    """Return a row of the table, for all results of a name."""
    errors, sigmas, times = (
        np.concatenate([one[key] for one in results])
        for key in ("errors", "uncertainties", "window_times")
    )
    steps = [tuple(step) for one in results for step in one["steps"]]
    # What looks like a limit cycle in the end of a step may be the answer to a push.
    calm, pushed = (cycles([step[:2] for step in steps if step[2] == kind]) for kind in (0, 1))
    answered = 100.0 * len(errors) / sum(one["estimates"] for one in results)
    accuracy, holds = "-", "-"
    if len(errors):
        rms, worst = math.degrees(np.sqrt(np.mean(errors**2))), math.degrees(np.abs(errors).max())
        accuracy = f"{rms:.2g}°, {worst:.2g}°"
        holds = f"{100.0 * np.mean(np.abs(errors) < 1.96 * sigmas):.0f} %"
    return (
        f"| {name} | {answered:.0f} % | {accuracy} | {holds} "
        f"| {calm} | {pushed} "
        f"| {1e3 * times.mean():.0f}, {1e3 * times.max():.0f} ms |"
    )


def cycles(steps):
    """Return how many of some steps end in a limit cycle, beside those with the true gap."""
    own, ideal = (sum(step[place] for step in steps) for place in (0, 1))
    avoidable = sum(cycle and not best for cycle, best in steps)
    return f"{own} of {len(steps)} ({avoidable}; {ideal})"


if __name__ == "__main__":
    sys.exit(main())
