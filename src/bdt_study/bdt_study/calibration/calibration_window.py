"""The forward model of a calibration: slopes from the simulation itself, a delay as it is.

The estimator states how voltage and friction act through a motor that settles at once, which is
right but for the transients. Over a minute those are what tells an offset from a drift and from a
gap that grows, and a fit with slopes that are off there creeps along.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bdt_twin.forward_model import StretchResponse
from bdt_twin.machine_knowledge import EFFECT_LIMITS, EFFECTS
from bdt_twin.model_factors import FACTORS
from bdt_twin.unknowns import Unknowns
from bdt_twin.window_model import WindowModel

FloatArray = NDArray[np.float64]

CHANGE = 1e-4
"""Change of a factor's logarithm or of a voltage [V] from which a slope is taken."""


class CalibrationWindow(WindowModel):
    """The forward model of the telemetry of a calibration; see :class:`WindowModel`."""

    # Slopes from the simulation want one that is smooth: no sample changes over to parts.
    longest_part = math.inf

    def coarse(self, lowest_rate: float, lowest_block_rate: float) -> "CalibrationWindow":
        """Return the window with fewer samples and blocks; see :meth:`WindowModel.coarse`."""
        copy = super().coarse(lowest_rate, lowest_block_rate)
        rate = copy.block_rate * copy.block
        return CalibrationWindow(
            self._model, copy.stretches, copy.knots, rate, copy.block, self.cogs
        )

    def simulate(self, unknowns: Unknowns) -> list[StretchResponse]:
        """Simulate each stretch; see :meth:`WindowModel.simulate`.

        The estimator's reading is late to first order, which at 1 ms is off by micrometers while
        the structure rings. Here it is to second order.
        """
        delay = float(unknowns.effects[EFFECTS.index("delay")])
        rate, responses = self.block_rate * self.block, []
        for run in super().simulate(unknowns):
            acceleration = np.gradient(np.gradient(run.position)) * rate * rate
            later = run.position + 0.5 * delay * delay * acceleration
            responses.append(run._replace(position=later))
        return responses

    def jacobian(self, unknowns: Unknowns, responses: list[StretchResponse]) -> FloatArray:
        """Return the Jacobian of the block means of the position, shape (unknowns, blocks)."""
        jacobian, knots = super().jacobian(unknowns, responses), self.knots.size
        before = self._block_means(responses)
        factors = unknowns.factors.copy()
        factors[FACTORS.index("gain")] += CHANGE
        after = self._block_means(self.simulate(replace(unknowns, factors=factors)))
        jacobian[knots + FACTORS.index("gain")] = (after - before) / CHANGE
        for name in ("friction_voltage", "voltage_offset"):
            place = len(FACTORS) + EFFECTS.index(name)
            jacobian[knots + place] = self._slope_by_voltage(unknowns, name)
        return jacobian

    def _slope_by_voltage(self, unknowns: Unknowns, name: str) -> FloatArray:
        """Return the slope of the block means by a voltage [m/V], from both sides.

        As long as the motor moves one way only, friction and offset are one unknown. Where it stops
        the position has a kink, and slopes from one side would tell them from each other.
        """
        place = EFFECTS.index(name)
        value, smallest = float(unknowns.effects[place]), float(EFFECT_LIMITS[0, place])
        below, above = max(value - CHANGE, smallest), value + CHANGE
        sides = []
        for changed in (below, above):
            effects = unknowns.effects.copy()
            effects[place] = changed
            responses = self.simulate(replace(unknowns, effects=effects))
            sides.append(self._block_means(responses))
        less, more = sides
        return (more - less) / (above - below)

    def _block_means(self, responses: list[StretchResponse]) -> FloatArray:
        means = [run.position.reshape(-1, self.block).mean(axis=1) for run in responses]
        return np.concatenate(means)
