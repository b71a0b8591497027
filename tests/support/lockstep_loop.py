"""The loop in lockstep under a schedule of faults: in simulated time, held against the cores."""

from functools import cache

import numpy as np
from fault_schedule import LAST, LONGEST
from faulted_loop import RECOVERY, FaultedLoop, LoopNode, Verdict

from bdt_controller.reference import ReferenceProfile
from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import PlantModel
from bdt_study.simulation.closed_loop import Scenario
from bdt_study.simulation.twin_loop import simulate_with_twin
from bdt_twin.dead_zone_tolerance import EQUATION_9
from bdt_twin.inverse_filter import InverseFilterEstimator, InverseFilterSettings
from bdt_twin.link import LinkSettings

JUDGED = 4.0
"""Simulated time for which the loop is compared at the end [s]: a step."""
DURATION = LAST + LONGEST + RECOVERY + JUDGED
TOLERANCE = 3e-4
"""Distance of the position to that without faults [m]: a controller that is new, or that has
waited, goes through its dead zone with another integral; 6 % of a step."""
LOCKSTEP_TIMEOUT = 30.0
"""Wall time for which the plant waits [s]: on a busy computer a twin takes long to start."""
GAP, STEP_TIME, DELAY = 0.2, 4.0, 0.3

NODES = {
    "controller": LoopNode(
        "bdt_controller.controller_node",
        ("use_sim_time:=true", f"reference.step_time:={STEP_TIME}"),
        ("command",),
    ),
    "twin": LoopNode(
        "bdt_twin.twin_node",
        ("use_sim_time:=true", f"communication_delay:={DELAY}", "service_timeout:=0.5"),
    ),
    "recorder": LoopNode("bdt_bags.recorder.recorder_node"),
    "plant": LoopNode(
        "bdt_plant.plant_node",
        (
            f"duration:={DURATION}",
            "gap.kind:=constant",
            f"gap.initial:={GAP}",
            "lockstep_followers:=[twin,recorder]",
            f"lockstep_timeout:={LOCKSTEP_TIMEOUT}",
            # Each lost measurement and command costs it in wall time.
            "resend_period:=0.02",
        ),
        ("measurement", "telemetry", "clock"),
    ),
}


@cache
def undisturbed():
    """Return times [s] and positions [m] of the loop without faults, from the cores alone."""
    scenario = Scenario(
        DURATION,
        ReferenceProfile(step_time=STEP_TIME),
        GapProfile(kind="constant", initial=GAP),
    )
    estimator = InverseFilterEstimator(PlantModel(), InverseFilterSettings())
    run = simulate_with_twin(
        scenario, estimator, LinkSettings(communication_delay=DELAY), EQUATION_9
    )
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
        times, expected = undisturbed()
        judged = rows[rows[:, 0] >= self._over_at]
        number = np.rint(judged[:, 0] * 5000.0).astype(int)
        np.testing.assert_allclose(times[number], judged[:, 0], atol=1e-9)
        off = float(np.abs(judged[:, 2] - expected[number]).max())
        text = f"{1e6 * off:.1f} um from the loop without faults after t = {self._over_at:g} s"
        return Verdict("recovered" if off <= TOLERANCE else "failed", text)
