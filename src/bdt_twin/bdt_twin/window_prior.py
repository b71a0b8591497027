"""What is known of a window's unknowns before its data are looked at."""

import math

import numpy as np
from numpy.typing import NDArray

from bdt_twin.fixed_order import weighted_products
from bdt_twin.machine_knowledge import MachineKnowledge
from bdt_twin.unknowns import INITIAL_CONDITION

FloatArray = NDArray[np.float64]

GAP_SPREAD = 10.0
"""Prior standard deviation of the gap [rad]: none, but a knot without data stays finite."""
GROWTH_SPREAD = math.radians(10.0)
"""Prior standard deviation of the mean growth rate [rad/s]."""
SHARE_SPREAD = 1.0
"""Prior standard deviation of where in the gap the motor begins."""


def prior_precision(knots: FloatArray, stretches: int, machine: MachineKnowledge) -> FloatArray:
    """Return the inverse covariance of the unknowns but for the changes of growth.

    Parameters
    ----------
    knots : ndarray, shape (knots,)
        Times of the gap's knots [s].
    stretches : int
        Number of stretches.
    machine : MachineKnowledge
        What is known of the machine.

    Returns
    -------
    ndarray, shape (unknowns, unknowns)
    """
    count, spacing = knots.size, float(knots[1] - knots[0])
    growth = np.diff(np.eye(count), axis=0) / spacing
    first = count + machine.expected.size
    size = first + len(INITIAL_CONDITION) * stretches
    prior = np.zeros((size, size))
    prior[:count, :count] = np.eye(count) / (GAP_SPREAD * GAP_SPREAD)
    spread = np.full(count - 1, 1.0 / (GROWTH_SPREAD * GROWTH_SPREAD * (count - 1)))
    prior[:count, :count] += weighted_products(growth.T, spread)
    prior[count:first, count:first] = machine.precision()
    shares = np.arange(first, size, len(INITIAL_CONDITION))
    prior[shares, shares] = 1.0 / (SHARE_SPREAD * SHARE_SPREAD)
    return prior
