"""The structure under forces that eq. 3 leaves out: stiffening beams, pushes, an elastic screw.

The linear part is discretised exactly for a screw that moves on a straight line within a step and
for forces that are constant within it. What is not linear is a force for the middle of the step,
from positions and velocities at its beginning, so the error is of second order in the step.

With an elastic screw (the paper's spring k_d) platform 1 has a mass and is a state:

    m q1'' = k_d (d - q1) + k (q2 - q1) + c (q2' - q1') + forces

With a rigid one q1 = d.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.quantities import quantity, validate
from bdt_plant.matrix_exponential import matrix_exponential
from bdt_plant.structure import StructureParameters, structure_state_space

Row = tuple[float, float, float, float, float, float, float, float, float, float, float]


@dataclass(frozen=True)
class BeamParameters:
    """What is not linear about the beams; the paper's are linear."""

    cubic_stiffness: float = quantity(
        0.0,
        "N/m^3",
        "k_3 in the force k x + k_3 x^3 of the beams between two platforms",
        minimum=0.0,
        maximum=1e15,
    )

    def __post_init__(self) -> None:
        validate(self)


class TowerState(NamedTuple):
    """Positions [m] and velocities [m/s] of the three platforms."""

    q1: float
    q1_velocity: float
    q2: float
    q2_velocity: float
    q3: float
    q3_velocity: float


class TowerRows(NamedTuple):
    """Rows of the exact linear map of one step.

    Each multiplies (q1, q1', q2, q2', q3, q3', d before, d after) and the forces on platforms 1, 2
    and 3.
    """

    q1: Row
    q1_velocity: Row
    q2: Row
    q2_velocity: Row
    q3: Row
    q3_velocity: Row


class DiscreteTower(NamedTuple):
    """The tower over one step.

    Attributes
    ----------
    rows : TowerRows
        Its linear part.
    half_step : float
        Half of the step [s].
    stiffness, damping, cubic_stiffness : float
        k [N/m], c [N s/m] and k_3 [N/m^3] of the beams.
    screw_stiffness : float
        k_d [N/m]; 0 for a rigid screw.
    """

    rows: TowerRows
    half_step: float
    stiffness: float
    damping: float
    cubic_stiffness: float
    screw_stiffness: float


def discretize_tower(
    structure: StructureParameters, beams: BeamParameters, screw_stiffness: float, step_time: float
) -> DiscreteTower:
    """Return the tower for one step.

    Parameters
    ----------
    structure : StructureParameters
        Masses and linear beams.
    beams : BeamParameters
        What is not linear.
    screw_stiffness : float
        Stiffness k_d of the lead screw [N/m]; 0 for a rigid one.
    step_time : float
        Length of the step [s].
    """
    a, to_d, to_force = _tower_state_space(structure, screw_stiffness)
    augmented = np.zeros((11, 11))
    augmented[:6, :6], augmented[:6, 6:8], augmented[:6, 8:] = a, to_d, to_force
    augmented[6, 7] = 1.0
    response = matrix_exponential(augmented * step_time)[:6]
    from_position, from_velocity = response[:, 6], response[:, 7] / step_time
    rows = np.column_stack(
        [response[:, :6], from_position - from_velocity, from_velocity, response[:, 8:]]
    )
    if screw_stiffness == 0.0:
        # Platform 1 is the end of the screw.
        rows[:2] = 0.0
        rows[0, 7], rows[1, 6:8] = 1.0, (-1.0 / step_time, 1.0 / step_time)
    return DiscreteTower(
        TowerRows(*(tuple(float(x) for x in row) for row in rows)),  # type: ignore[arg-type]
        0.5 * step_time,
        float(structure.stiffness),
        float(structure.damping),
        float(beams.cubic_stiffness),
        float(screw_stiffness),
    )


def _tower_state_space(
    structure: StructureParameters, screw_stiffness: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return state matrix (6, 6), inputs of (d, d') (6, 2) and of the forces (6, 3)."""
    upper, from_base = structure_state_space(structure)
    a, to_d, to_force = np.zeros((6, 6)), np.zeros((6, 2)), np.zeros((6, 3))
    a[2:, 2:] = upper
    to_force[3, 1] = 1.0 / structure.mass
    to_force[5, 2] = to_force[3, 1] / structure.top_mass_ratio
    if screw_stiffness == 0.0:
        to_d[2:] = from_base
        return a, to_d, to_force
    k, c = structure.stiffness / structure.mass, structure.damping / structure.mass
    k_d = screw_stiffness / structure.mass
    a[2:, :2] = from_base
    a[0, 1] = 1.0
    a[1, :4] = -k_d - k, -c, k, c
    to_d[1, 0] = k_d
    to_force[1, 0] = 1.0 / structure.mass
    return a, to_d, to_force


def screw_force(tower: TowerState, d: float, d_velocity: float, step: DiscreteTower) -> float:
    """Return the force with which the tower resists the screw in the middle of a step [N].

    Through a rigid screw that is the force of the beams: platform 1 then has no mass.

    Parameters
    ----------
    tower : TowerState
        Tower at the beginning of the step.
    d, d_velocity : float
        Position of the screw's end at the beginning of the step [m], and its velocity [m/s].
    step : DiscreteTower
        From :func:`discretize_tower`.
    """
    d_middle = d + step.half_step * d_velocity
    if step.screw_stiffness > 0.0:
        return step.screw_stiffness * (d_middle - tower.q1 - step.half_step * tower.q1_velocity)
    bent = d_middle - tower.q2 - step.half_step * tower.q2_velocity
    viscous = step.damping * (d_velocity - tower.q2_velocity)
    return step.stiffness * bent + step.cubic_stiffness * bent * bent * bent + viscous


def tower_step(
    tower: TowerState,
    d_before: float,
    d_after: float,
    push_2: float,
    push_3: float,
    step: DiscreteTower,
) -> TowerState:
    """Advance the three platforms by one step (eq. 3 and what it leaves out).

    Parameters
    ----------
    tower : TowerState
        Tower at the beginning of the step.
    d_before, d_after : float
        Position of the screw's end at the beginning and end of the step [m].
    push_2, push_3 : float
        Forces on platforms 2 and 3 [N].
    step : DiscreteTower
        From :func:`discretize_tower`.
    """
    q1, v1, q2, v2, q3, v3 = tower
    half = step.half_step
    if step.screw_stiffness > 0.0:
        lower = q1 - q2 + half * (v1 - v2)
    else:
        lower = 0.5 * (d_before + d_after) - q2 - half * v2
    upper = q2 - q3 + half * (v2 - v3)
    lower_force = step.cubic_stiffness * lower * lower * lower
    upper_force = step.cubic_stiffness * upper * upper * upper
    force_2, force_3 = push_2 + lower_force - upper_force, push_3 + upper_force
    given = (q1, v1, q2, v2, q3, v3, d_before, d_after, -lower_force, force_2, force_3)
    return TowerState(
        _product(step.rows.q1, given),
        _product(step.rows.q1_velocity, given),
        _product(step.rows.q2, given),
        _product(step.rows.q2_velocity, given),
        _product(step.rows.q3, given),
        _product(step.rows.q3_velocity, given),
    )


def _product(row: Row, given: Row) -> float:
    """Return the sum of products, added in the order of the row."""
    total = 0.0
    for column in range(11):
        total += row[column] * given[column]
    return total
