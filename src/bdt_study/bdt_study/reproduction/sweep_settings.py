"""How much of what the paper leaves open ``bdt reproduce`` tries."""

from dataclasses import dataclass, field

import numpy as np

from bdt_study.reproduction.claim_robustness import OpenChoice, open_choices
from bdt_study.reproduction.dead_zone_sweep import RATIOS
from bdt_study.reproduction.decision_sweep import GAPS
from bdt_study.reproduction.delay_sweep import DELAYS, RANDOM_RUNS


@dataclass(frozen=True)
class SweepSettings:
    """The sweeps; the figures of the paper are the same at any size.

    Attributes
    ----------
    delays : tuple of float
        Fixed delays of the link [s], increasing, 0 and 1 s among them.
    random_delays : int
        Number of runs with random delays.
    dead_zone_ratios : tuple of float
        Widths of the dead zone over that of the true gap.
    choices : tuple of OpenChoice
        Other choices for which all claims are asked again.
    gaps : tuple of float
        Constant gaps at which limit cycles are predicted and simulated [rad].
    stiffness_factors : tuple of float
        Factors on the stiffness at which they are compared again.
    decision_gaps : tuple of float
        Constant gaps at which ways to decide on the dead zone are compared [deg].
    """

    delays: tuple[float, ...] = DELAYS
    random_delays: int = RANDOM_RUNS
    dead_zone_ratios: tuple[float, ...] = RATIOS
    choices: tuple[OpenChoice, ...] = field(default_factory=open_choices)
    gaps: tuple[float, ...] = tuple(np.deg2rad([2.5, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0]).tolist())
    stiffness_factors: tuple[float, ...] = tuple(np.geomspace(0.8, 60.0, 14).tolist())
    decision_gaps: tuple[float, ...] = GAPS
