"""A loop in Python that does nothing but wake up in time: the floor of what is done in real time.

``python -m ... RATE DURATION PRIORITY`` prints a line of JSON: how late it woke, in each period.
"""

import json
import sys
import time
from collections.abc import Iterator

from bdt_msgs_py.real_time import RealTimeSettings, enter_real_time


def periods(rate: float, duration: float) -> Iterator[int]:
    """Wake up at a rate and yield each time how late it was [ns].

    Periods that are over when the work of one is done are left out.

    Parameters
    ----------
    rate : float
        Periods per second [Hz].
    duration : float
        How long [s].
    """
    period = round(1e9 / rate)
    due = time.monotonic_ns() + period
    end = due + round(duration * rate) * period
    while due < end:
        time.sleep(max(due - time.monotonic_ns(), 0) * 1e-9)
        yield time.monotonic_ns() - due
        due += max(-(-(time.monotonic_ns() - due) // period), 1) * period


def real_time_settings(priority: int) -> RealTimeSettings:
    """Return all there is for a process in real time with a priority; with 0 nothing at all."""
    is_on = priority > 0
    return RealTimeSettings(priority, lock_memory=is_on, collect_in_slack=is_on)


def report(times: list[int], refusals: list[str]) -> None:
    """Print what was measured [ns], one number a period, and what the machine has refused."""
    print(json.dumps({"nanoseconds": times, "refusals": refusals}), flush=True)


def main() -> None:
    """Measure as the command line says."""
    rate, duration, priority = sys.argv[1:]
    refusals = enter_real_time(real_time_settings(int(priority)))
    report(list(periods(float(rate), float(duration))), refusals)


if __name__ == "__main__":
    main()
