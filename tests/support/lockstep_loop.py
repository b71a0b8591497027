"""The loop in lockstep under a schedule of faults: in simulated time, held against the cores."""

import signal
from functools import cache
from math import ceil

import numpy as np
from fault_schedule import LAST, LONGEST
from faulted_loop import DEADLINE, RECOVERY, FaultedLoop, LoopNode, Verdict

from bdt_controller.reference import ReferenceProfile
from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import PlantModel, Sampling
from bdt_study.simulation.closed_loop import Scenario
from bdt_study.simulation.twin_loop import simulate_with_twin
from bdt_twin.dead_zone_tolerance import DeadZoneSettings
from bdt_twin.inverse_filter import InverseFilterEstimator, InverseFilterSettings
from bdt_twin.link import LinkSettings

STEP_TIME = 4.0
"""Time for which the reference stays, and for which the loop is compared [s]."""
DURATION = STEP_TIME * (ceil((LAST + LONGEST + RECOVERY) / STEP_TIME) + 1)
"""Time at which the last step that can be compared has ended [s]."""
TOLERANCE = 3e-4
"""Distance of the position to that without faults [m]: a controller that is new, or that has
waited, goes through its dead zone with another integral; 6 % of a step."""
AT_REST = 1.5e-4
"""Peak to peak in the last second of a step [m]: 175 um in the limit cycle of a loop without a dead
zone, 166 um and more with one of a fifth of the gap. With one of 0.9 to 1.5 gaps a step rings down
to 20 to 142 um, whichever its beginning leads to."""
LOCKSTEP_TIMEOUT = 30.0
"""Wall time for which the plant waits [s]: on a busy computer a twin takes long to start."""
GAP, DELAY = 0.2, 0.3
DEAD_ZONE = DeadZoneSettings(ratio=1.25)
"""Wide enough for a loop that comes to rest within a step, whatever its controller began with."""
SAMPLING = Sampling(sampling_rate=2000.0, control_rate=200.0)
"""Fewer periods than usual: a schedule is run for its faults."""

NODES = {
    "controller": LoopNode(
        "bdt_controller.controller_node",
        (
            "use_sim_time:=true",
            f"reference.step_time:={STEP_TIME}",
            f"control_rate:={SAMPLING.control_rate}",
        ),
        ("command",),
    ),
    "twin": LoopNode(
        "bdt_twin.twin_node",
        (
            "use_sim_time:=true",
            f"communication_delay:={DELAY}",
            "service_timeout:=0.5",
            f"estimator.sampling_rate:={SAMPLING.sampling_rate}",
            f"dead_zone.ratio:={DEAD_ZONE.ratio}",
        ),
    ),
    "recorder": LoopNode("bdt_bags.recorder.recorder_node"),
    "plant": LoopNode(
        "bdt_plant.plant_node",
        (
            f"duration:={DURATION}",
            "gap.kind:=constant",
            f"gap.initial:={GAP}",
            f"sampling_rate:={SAMPLING.sampling_rate}",
            f"control_rate:={SAMPLING.control_rate}",
            "lockstep_followers:=[twin,recorder]",
            f"lockstep_timeout:={LOCKSTEP_TIMEOUT}",
            # Each lost measurement and command costs it in wall time.
            "resend_period:=0.02",
        ),
        ("measurement", "telemetry", "clock"),
    ),
}


def loop_without_faults():
    """Return the scenario of the loop, to which a twin may come."""
    return Scenario(
        DURATION,
        ReferenceProfile(step_time=STEP_TIME),
        GapProfile(kind="constant", initial=GAP),
        sampling=SAMPLING,
    )


@cache
def undisturbed():
    """Return times [s] and positions [m] of the loop without faults, from the cores alone."""
    settings = InverseFilterSettings(sampling_rate=SAMPLING.sampling_rate)
    estimator = InverseFilterEstimator(PlantModel(), settings)
    link = LinkSettings(communication_delay=DELAY)
    run = simulate_with_twin(loop_without_faults(), estimator, link, DEAD_ZONE)
    return run.loop.t, run.loop.q3


class LockstepLoop(FaultedLoop):
    """Plant, controller, twin and recorder; over when the loop is back, or the plant has ended."""

    def __init__(self, schedule, domain):
        super().__init__(NODES, schedule, domain)
        over = max((fault.end for fault in schedule), default=0.0)
        self._step, self._last_step = (ceil(time / STEP_TIME) for time in (over, over + RECOVERY))
        self._seen = Verdict("failed", "the plant has ended before a step could be compared")

    def _is_over(self):
        plant = self._running["plant"]
        if plant.poll() is None and self._is_decided():
            plant.send_signal(signal.SIGINT)
            plant.wait(DEADLINE)
        return plant.poll() is not None

    def _is_decided(self):
        """Tell whether a whole step after all faults was as without them, or none will be."""
        while self._step <= self._last_step and self._knows((self._step + 1) * STEP_TIME):
            self._seen = verdict_on(np.concatenate(self._rows), self._step * STEP_TIME)
            self._step += 1
        is_calm = not self._due and not self._passing
        return self._step > self._last_step or (is_calm and self._seen.outcome == "recovered")

    def _knows(self, time):
        """Tell whether the telemetry reaches as far as a time [s]."""
        return bool(self._rows) and self._rows[-1][-1, 0] > time - 1.5 / SAMPLING.sampling_rate

    def _verdict(self, _rows, said):
        code = self._running["plant"].returncode
        if code != 0:
            errors = [line for line in said.splitlines() if line.startswith("error: ")]
            if code == 1 and len(errors) == 1 and " waited " in errors[0]:
                return Verdict("stood still", errors[0])
            return Verdict("failed", f"the plant ended with {code}: {said}")
        self._is_decided()
        return self._seen


def verdict_on(rows, begin):
    """Return how a loop stands in a step of its reference.

    Parameters
    ----------
    rows : ndarray, shape (n, 3)
        Its telemetry, (t [s], u [V], q3 [m]).
    begin : float
        Time at which the step begins [s].
    """
    times, expected = undisturbed()
    end = begin + STEP_TIME
    judged = rows[(rows[:, 0] >= begin) & (rows[:, 0] < end)]
    number = np.rint(judged[:, 0] * SAMPLING.sampling_rate).astype(int)
    np.testing.assert_allclose(times[number], judged[:, 0], atol=1e-9)
    off = float(np.abs(judged[:, 2] - expected[number]).max())
    swing = float(np.ptp(judged[judged[:, 0] >= end - 1.0, 2]))
    text = (
        f"{1e6 * off:.1f} um from the loop without faults at {begin:g} to {end:g} s, "
        f"{1e6 * swing:.0f} um peak to peak in its last second"
    )
    return Verdict("recovered" if off <= TOLERANCE and swing <= AT_REST else "failed", text)
