"""Runs the loop for long and tells what each process holds: memory, descriptors, threads.

    python tests/faults/endurance.py --periods 1e7
    python tests/faults/endurance.py --real-time --periods 1.8e6

Prints a line for each process now and then, and in the end what has grown and what was lost.
Exit code 1 if more has grown than a megabyte in 1e7 periods, or a message was lost.
"""

import argparse
import os
import sys
import tempfile
import threading
from pathlib import Path

import yaml

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS / "support"), str(TESTS / "conformance")]

os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"

from process_usage import growth, usage_of  # noqa: E402
from ros_domain import claim_domain  # noqa: E402
from running_loops import children  # noqa: E402

from bdt_bringup.configuration import load_configuration  # noqa: E402
from bdt_bringup.run import run_loop  # noqa: E402
from bdt_bringup.run_plan import plan_run  # noqa: E402

RATE = 500.0
"""Control rate of the paper's configuration [Hz]."""
CONFIGURATION = TESTS.parent / "config" / "paper.yaml"
LARGEST_GROWTH = 1e6
"""Memory by which a process may grow in :data:`MANY_PERIODS` [byte]."""
MANY_PERIODS = 1e7
SPLIT_SIZE = 1 << 26
"""Size of the files of the bag [byte]: the index of each one is in memory until its end."""


class Watch:
    """Looks at the nodes of `bdt run` at intervals, in a thread of its own."""

    def __init__(self, interval):
        self.usages = {}
        self._interval, self._ended = interval, threading.Event()
        self._thread = threading.Thread(target=self._look, daemon=True)
        self._thread.start()

    def _look(self):
        while not self._ended.wait(self._interval):
            for name, pid in {**children(os.getpid()), "bdt run": os.getpid()}.items():
                try:
                    usage = usage_of(pid)
                except (FileNotFoundError, ProcessLookupError):
                    continue  # it has ended meanwhile
                self.usages.setdefault(name, []).append(usage)
                print(f"{name}: {usage}", flush=True)

    def end(self):
        """Look no more."""
        self._ended.set()
        self._thread.join()


def main():
    """Run the loop; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--periods", type=float, default=MANY_PERIODS, help="control periods")
    parser.add_argument("--real-time", action="store_true", help="not as fast as it goes")
    parser.add_argument("--interval", type=float, default=60.0, help="between two looks [s]")
    options = parser.parse_args()
    os.environ["ROS_DOMAIN_ID"] = str(claim_domain())
    with tempfile.TemporaryDirectory() as folder:
        plan = plan_run(
            load_configuration(CONFIGURATION),
            mode="realtime" if options.real_time else "lockstep",
            duration=options.periods / RATE,
            processes="separate",
            output=Path(folder) / "run",
            recorder={"split_size": SPLIT_SIZE},
        )
        watch = Watch(options.interval)
        try:
            run_loop(plan)
        finally:
            watch.end()
        faults = lost_messages(plan.bag, options.periods)
    for name, usages in watch.usages.items():
        grown = growth(usages)
        print(f"{name}: grown by {grown.memory / 1e6:.2f} MB in {grown.time:.0f} s, {usages[-1]}")
        passed = grown.time / (usages[-1].time - usages[0].time) * options.periods
        allowed = LARGEST_GROWTH * max(passed / MANY_PERIODS, 1.0)
        if grown.memory > allowed or grown.descriptors > 0 or grown.threads > 0:
            faults.append(f"{name} has grown: {grown}")
    print("; ".join(faults) or "endurance: all is well")
    return int(bool(faults))


def lost_messages(bag, periods):
    """Return what is missing in a bag, as far as its counts tell."""
    text = (bag / "metadata.yaml").read_text(encoding="utf-8")
    known = yaml.safe_load(text)["rosbag2_bagfile_information"]
    counts = {
        one["topic_metadata"]["name"]: one["message_count"]
        for one in known["topics_with_message_count"]
    }
    print(f"recorded: {counts}, {known['custom_data']}")
    faults = [
        f"{name} = {known['custom_data'][name]}"
        for name in ("messages_lost", "messages_dropped")
        if known["custom_data"][name] != "0"
    ]
    few = [name for name in ("/measurement", "/command") if counts[name] < round(periods)]
    return faults + [f"{counts[name]} messages of {name} in {periods:.0f} periods" for name in few]


if __name__ == "__main__":
    sys.exit(main())
