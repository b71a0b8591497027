"""What a controller is tuned for."""

import math
from dataclasses import dataclass

from bdt_msgs_py.quantities import quantity, validate
from bdt_study.tuning.candidate_outcome import Candidate

BANDWIDTH_ERROR = 0.02
"""Share by which the bandwidth may be off."""


@dataclass(frozen=True)
class Targets:
    """What is asked for besides no steady-state error."""

    bandwidth: float = quantity(
        10.0,
        "rad/s",
        "first gain crossover with the mechanism as it is believed to be; the paper's is 10",
        minimum=1e-2,
        maximum=1e3,
    )
    phase_margin: float = quantity(
        math.radians(10.0),
        "rad",
        "smallest phase margin over all mechanisms; the paper's is 10 degrees",
        minimum=0.0,
        maximum=math.pi / 2,
    )
    success: float = quantity(
        0.99, "", "share of the random loops without a limit cycle", minimum=0.0, maximum=1.0
    )
    sensitivity: float = quantity(
        3.7, "", "largest sensitivity over all mechanisms", minimum=1.0, maximum=1e3
    )
    settling: float = quantity(
        1.2,
        "",
        "median settling time over that of the gains so far on the nominal mechanism",
        minimum=0.0,
        maximum=1e3,
    )

    def __post_init__(self) -> None:
        validate(self)

    def lacks(self, candidate: Candidate, baseline: Candidate) -> list[str]:
        """Return what a candidate does not reach, a text for each.

        Parameters
        ----------
        candidate : Candidate
            The candidate.
        baseline : Candidate
            Gains so far on the nominal mechanism.
        """
        linear, settling = candidate.linear, candidate.settling / baseline.settling
        wanted = {
            "no steady-state error": linear.integrates and linear.stable,
            f"bandwidth {linear.bandwidth:.3g} rad/s, not {self.bandwidth:g}": abs(
                linear.bandwidth / self.bandwidth - 1.0
            )
            <= BANDWIDTH_ERROR,
            f"phase margin {math.degrees(linear.smallest_phase_margin):.1f} deg, not "
            f"{math.degrees(self.phase_margin):g}": (
                linear.smallest_phase_margin >= self.phase_margin
            ),
            f"sensitivity {linear.largest_sensitivity:.2f}, not {self.sensitivity:g}": (
                linear.largest_sensitivity <= self.sensitivity
            ),
            f"{100 * candidate.success:.1f} % without a limit cycle, not {100 * self.success:g}": (
                candidate.success >= self.success
            ),
            f"settling {settling:.2f} times as long, not {self.settling:g}": (
                settling <= self.settling
            ),
        }
        return [text for text, reached in wanted.items() if not reached]
