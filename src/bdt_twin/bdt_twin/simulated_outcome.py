"""What simulated steps come to: a limit cycle or rest, with what bias and after what time."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_controller.control_law import ControlLaw
from bdt_twin.decision_loop import Member, simulate_steps

FloatArray = NDArray[np.float64]

SETTLED = 0.02
"""Share of a step's height within which it has settled."""
CYCLE = 0.005
"""Peak to peak, as a share of the height, from which on what is sustained is a limit cycle: half
of what the report calls one."""
DECAY = 2.0 / 3.0
"""Peak to peak of the last quarter of a step over that of the quarter before, from which on an
oscillation is sustained."""


class SimulatedOutcome(NamedTuple):
    """What came of all steps with all mechanisms.

    Attributes
    ----------
    failed : bool
        Whether one of them ends in a limit cycle.
    bias : float
        Largest distance from the reference at the end of a step, as a share of its height.
    settling : float
        Median time after which a step has settled [s].
    longest : float
        Longest settling time [s].
    """

    failed: bool
    bias: float
    settling: float
    longest: float


FAILED = SimulatedOutcome(True, np.inf, np.inf, np.inf)


class StepTrials:
    """Simulates steps up and down with mechanisms, as far as it takes to know that one fails.

    Parameters
    ----------
    heights : sequence of float
        Heights of the steps [m].
    step_time : float
        Length of each [s].
    control_rate : float
        Rate of measurements [Hz].
    limit : float
        Voltage limit of the controller [V]; 0 for none.
    """

    def __init__(
        self, heights: Sequence[float], step_time: float, control_rate: float, limit: float
    ) -> None:
        self._rate, self._limit = control_rate, limit
        self._length = round(step_time * control_rate)
        levels = [level for height in heights for level in (height, 0.0)]
        self._heights = [height for height in heights for _ in range(2)]
        self._levels = levels
        self._references = np.repeat(np.array(levels), self._length)

    def outcome(
        self, members: Sequence[Member], law: ControlLaw, tolerance: float
    ) -> SimulatedOutcome:
        """Return what comes of a controller with a dead zone.

        Parameters
        ----------
        members : sequence of Member
            Mechanisms.
        law : ControlLaw
            Controller.
        tolerance : float
            Dead-zone tolerance epsilon_dz [m].
        """
        biases, settled = [0.0], [0.0]
        for member in members:
            positions, voltages = simulate_steps(
                member, law, tolerance, self._limit, self._references
            )
            if not np.isfinite(positions[-1]):
                return FAILED
            for number, (level, height) in enumerate(zip(self._levels, self._heights, strict=True)):
                part = slice(number * self._length, (number + 1) * self._length)
                position, voltage = positions[part], voltages[part]
                if is_limit_cycle(position, voltage, height):
                    return FAILED
                biases.append(abs(float(position[-1]) - level) / height)
                settled.append(self._last(np.abs(position - position[-1]) > SETTLED * height))
        return SimulatedOutcome(
            False, max(biases), sorted(settled)[len(settled) // 2], max(settled)
        )

    def _last(self, happens: NDArray[np.bool_]) -> float:
        """Return the time after which something does not happen any more [s]."""
        places = np.flatnonzero(happens)
        return (int(places[-1]) + 1) / self._rate if places.size else 0.0


def is_limit_cycle(position: FloatArray, voltage: FloatArray, height: float) -> bool:
    """Tell whether a step ends in a limit cycle.

    Parameters
    ----------
    position : ndarray, shape (n,)
        q3 at each measurement of the step [m].
    voltage : ndarray, shape (n,)
        Voltage commanded [V]; zero in the dead zone.
    height : float
        Height of the step [m].
    """
    quarter = position.size // 4
    last, before = position[-quarter:], position[-2 * quarter : -quarter]
    if not voltage[-quarter:].any():
        return False
    swing = float(np.ptp(last))
    return swing > CYCLE * height and swing >= DECAY * float(np.ptp(before))
