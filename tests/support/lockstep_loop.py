"""The loop in lockstep under a schedule of faults: in simulated time, held against the cores."""

from functools import cache

import numpy as np
from fault_schedule import LAST, LONGEST
from faulted_loop import RECOVERY, FaultedLoop, LoopNode, Verdict

from bdt_controller.reference import ReferenceProfile
from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import PlantModel, Sampling
from bdt_study.simulation.closed_loop import Scenario
from bdt_study.simulation.twin_loop import simulate_with_twin
from bdt_twin.dead_zone_tolerance import DeadZoneSettings
from bdt_twin.inverse_filter import InverseFilterEstimator, InverseFilterSettings
from bdt_twin.link import LinkSettings

JUDGED = 4.0
"""Simulated time for which the loop is compared at the end [s]: a step."""
DURATION = LAST + LONGEST + RECOVERY + JUDGED
TOLERANCE = 3e-4
"""Distance of the position to that without faults [m]: a controller that is new, or that has
waited, goes through its dead zone with another integral; 6 % of a step."""
AT_REST = 1.5e-4
"""Peak to peak in the last second of a step [m]: 175 um in the limit cycle of a loop without a dead
zone, 166 um and more with one of a fifth of the gap. With one of 0.9 to 1.5 gaps a step rings down
to 20 to 142 um, whichever its beginning leads to."""
LOCKSTEP_TIMEOUT = 30.0
"""Wall time for which the plant waits [s]: on a busy computer a twin takes long to start."""
GAP, STEP_TIME, DELAY = 0.2, 4.0, 0.3
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
    """Plant, controller, twin and recorder; the plant's end is that of the loop."""

    def __init__(self, schedule, domain):
        super().__init__(NODES, schedule, domain)

    def _is_over(self):
        return self._running["plant"].poll() is not None

    def _verdict(self, rows, said):
        code = self._running["plant"].returncode
        if code != 0:
            errors = [line for line in said.splitlines() if line.startswith("error: ")]
            if code == 1 and len(errors) == 1 and " waited " in errors[0]:
                return Verdict("stood still", errors[0])
            return Verdict("failed", f"the plant ended with {code}: {said}")
        return verdict_on(rows, self._over_at)


def verdict_on(rows, begin):
    """Return how a loop stands that has run to its end.

    Parameters
    ----------
    rows : ndarray, shape (n, 3)
        Its telemetry, (t [s], u [V], q3 [m]).
    begin : float
        Time from which on it is to be as without faults [s].
    """
    times, expected = undisturbed()
    judged = rows[rows[:, 0] >= begin]
    number = np.rint(judged[:, 0] * SAMPLING.sampling_rate).astype(int)
    np.testing.assert_allclose(times[number], judged[:, 0], atol=1e-9)
    off = float(np.abs(judged[:, 2] - expected[number]).max())
    ends = [end for end in np.arange(STEP_TIME, DURATION, STEP_TIME) if end - 1.0 >= begin]
    swing = max(
        float(np.ptp(judged[(judged[:, 0] >= end - 1.0) & (judged[:, 0] < end), 2])) for end in ends
    )
    text = (
        f"{1e6 * off:.1f} um from the loop without faults after t = {begin:g} s, "
        f"{1e6 * swing:.0f} um peak to peak at the ends of steps"
    )
    return Verdict("recovered" if off <= TOLERANCE and swing <= AT_REST else "failed", text)
