"""Flexible three-mass structure (eq. 3), discretised exactly for a linearly moving base.

The lead screw is rigid, so the bottom platform follows it: q1 = d. Platforms 2 and 3 obey

    m q2'' = k (q1 - q2) + c (q1' - q2') + k (q3 - q2) + c (q3' - q2')
    r m q3'' = k (q2 - q3) + c (q2' - q3')

whose transfer function from d to q3 is eq. 3 where platform 3 is as heavy as platform 2 (r = 1).
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.quantities import quantity, validate
from bdt_plant.matrix_exponential import Exponential, matrix_exponential

Row = tuple[float, float, float, float, float, float]


@dataclass(frozen=True)
class StructureParameters:
    """Mass, elasticity and dissipation of each storey (table 1)."""

    mass: float = quantity(5.2, "kg", "mass m of a platform", minimum=1e-6, maximum=1e6)
    stiffness: float = quantity(
        1e4, "N/m", "stiffness k of the beams between two platforms", minimum=1e-3, maximum=1e12
    )
    damping: float = quantity(
        36.9, "N s/m", "dissipation c of the beams between two platforms", minimum=0.0, maximum=1e9
    )
    top_mass_ratio: float = quantity(
        1.0,
        "",
        "mass of platform 3, with what it carries, over that of platform 2",
        minimum=0.01,
        maximum=100.0,
    )

    def __post_init__(self) -> None:
        validate(self)


class StructureState(NamedTuple):
    """Positions [m] and velocities [m/s] of platforms 2 and 3."""

    q2: float
    q2_velocity: float
    q3: float
    q3_velocity: float


class DiscreteStructure(NamedTuple):
    """Rows of the exact one-sample map; each multiplies (q2, q2', q3, q3', d before, d after)."""

    q2: Row
    q2_velocity: Row
    q3: Row
    q3_velocity: Row


def structure_state_space(
    structure: StructureParameters,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the continuous model for (q2, q2', q3, q3') driven by (d, d').

    Returns
    -------
    a : ndarray, shape (4, 4)
        State matrix.
    b : ndarray, shape (4, 2)
        Input matrix for the base's position [m] and velocity [m/s].
    """
    k = structure.stiffness / structure.mass
    c = structure.damping / structure.mass
    top = np.array([k, c, -k, -c]) / structure.top_mass_ratio
    a = np.array([[0, 1, 0, 0], [-2 * k, -2 * c, k, c], [0, 0, 0, 1], top])
    b = np.array([[0, 0], [k, c], [0, 0], [0, 0]])
    return a, b


# The contact asks for the same again, and so do fits that change the motor alone.
@lru_cache(maxsize=256)
def discretize_structure(
    structure: StructureParameters,
    sample_time: float,
    exponential: Exponential = matrix_exponential,
) -> DiscreteStructure:
    """Return the ramp-invariant equivalent: exact when d is linear in time over each sample.

    Parameters
    ----------
    structure : StructureParameters
        Constants of the structure.
    sample_time : float
        Sample time [s].
    exponential : callable
        Returns the exponential of a matrix.
    """
    a, b = structure_state_space(structure)
    # The base's position and velocity join the state; its velocity is constant over the sample.
    augmented = np.zeros((6, 6))
    augmented[:4, :4], augmented[:4, 4:] = a, b
    augmented[4, 5] = 1.0
    one_sample = exponential(augmented * sample_time)
    from_position, from_velocity = one_sample[:4, 4], one_sample[:4, 5] / sample_time
    rows = np.column_stack([one_sample[:4, :4], from_position - from_velocity, from_velocity])
    return DiscreteStructure(*(tuple(float(x) for x in row) for row in rows))  # type: ignore[arg-type]


def structure_step(
    state: StructureState, d_before: float, d_after: float, step: DiscreteStructure
) -> StructureState:
    """Advance platforms 2 and 3 by one sample (eq. 3).

    Parameters
    ----------
    state : StructureState
        State at the beginning of the sample.
    d_before, d_after : float
        Position of the lead screw's end at the beginning and end of the sample [m].
    step : DiscreteStructure
        From :func:`discretize_structure`.
    """
    q2, v2, q3, v3 = state
    a1, a2, a3, a4, a5, a6 = step.q2
    b1, b2, b3, b4, b5, b6 = step.q2_velocity
    c1, c2, c3, c4, c5, c6 = step.q3
    e1, e2, e3, e4, e5, e6 = step.q3_velocity
    return StructureState(
        a1 * q2 + a2 * v2 + a3 * q3 + a4 * v3 + a5 * d_before + a6 * d_after,
        b1 * q2 + b2 * v2 + b3 * q3 + b4 * v3 + b5 * d_before + b6 * d_after,
        c1 * q2 + c2 * v2 + c3 * q3 + c4 * v3 + c5 * d_before + c6 * d_after,
        e1 * q2 + e2 * v2 + e3 * q3 + e4 * v3 + e5 * d_before + e6 * d_after,
    )
