"""The twin's model with factors on the constants that a fit corrects, discrete and remembered.

A fit asks for slightly different models at each of its steps, but making one discrete takes several
times as long as looking it up. So models are made on a grid of factors, remembered, and
interpolated.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache, reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_plant.elementary_functions import exponential
from bdt_plant.motor import DiscreteMotor, discretize_motor
from bdt_plant.plant import DiscretePlant, PlantModel, discretize_plant
from bdt_plant.quick_exponential import quick_exponential
from bdt_plant.structure import DiscreteStructure, discretize_structure

FloatArray = NDArray[np.float64]
Point = tuple[int, ...]

FACTORS = ("gain", "stiffness", "damping")
"""Factors on the model: of the motor's gain 1/k_B, of k/m and of c/m."""
MODEL_FACTORS = (*FACTORS, "top_mass")
"""All factors on the model; the last one, of the mass of platform 3 over that of platform 2, is one
for a machine that carries what it is said to carry."""

OF_STRUCTURE = np.array([0.0, 1.0, 1.0, 1.0])
"""One for factors on the structure; the motor's gain has no part in it."""
FACTOR_GRID = np.array([2e-2, 2e-2, 5e-2, 2.5e-3])
"""Spacing of the natural logarithms of ``MODEL_FACTORS``. The model depends least on the damping.
The mass divides stiffness and damping: parabolas along the axes miss that in larger steps."""
ROOM = (0.5, 3.0)
"""Factors by which a constant may be corrected."""
MOST_GRIDS, MOST_POINTS = 32, 1024
"""Models, and points of the grid of each, that are remembered."""


def model_with(model: PlantModel, factors: FloatArray) -> PlantModel:
    """Return the model for natural logarithms of ``FACTORS`` or of all ``MODEL_FACTORS``."""
    gain, stiffness, damping, top_mass = exponential(_of_all(factors)).tolist()
    motor, structure = model.motor, model.structure
    return replace(
        model,
        motor=replace(motor, back_emf_constant=motor.back_emf_constant / gain),
        structure=replace(
            structure,
            stiffness=structure.stiffness * stiffness,
            damping=structure.damping * damping,
            top_mass_ratio=structure.top_mass_ratio * top_mass,
        ),
    )


def check_room(model: PlantModel) -> None:
    """Refuse a model whose constants lie so near to their limits that a fit would leave these.

    Raises
    ------
    ValueError
        If a constant that is corrected cannot be half or three times as large.
    """
    for factor in ROOM:
        try:
            model_with(model, np.full(len(MODEL_FACTORS), np.log(factor)))
        except ValueError as error:
            raise ValueError(
                f"{error}, also {factor:g} times as large: the estimator corrects it"
            ) from error


def plant_step_with(model: PlantModel, factors: FloatArray, sample_time: float) -> DiscretePlant:
    """Return the discrete model of the plant with its factors, interpolated.

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism without factors.
    factors : ndarray, shape (3,) or (4,)
        Natural logarithms of ``FACTORS`` or of all ``MODEL_FACTORS``.
    sample_time : float
        Sample time [s].
    """
    grid = _plant_grid(model, sample_time)
    numbers = grid.numbers_at(_of_all(factors))
    motor, structure, contact = np.split(numbers, [9, 33])
    # Whatever else a step holds does not depend on the factors.
    origin: DiscretePlant = grid.origin
    return origin._replace(
        motor=type(origin.motor)(*_rows(motor, 3)),
        structure=DiscreteStructure(*_rows(structure, 4)),
        contact=type(origin.contact)(*_rows(contact, 4)),
        pitch=float(origin.pitch),
    )


def motor_step_with(model: PlantModel, factors: FloatArray, step_time: float) -> DiscreteMotor:
    """Return the discrete model of the motor with its factors, interpolated.

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism without factors.
    factors : ndarray, shape (3,) or (4,)
        Natural logarithms of ``FACTORS`` or of all ``MODEL_FACTORS``; the motor has the gain alone.
    step_time : float
        Time that a step takes [s].
    """
    of_motor = _of_all(factors) * (1.0 - OF_STRUCTURE)
    return DiscreteMotor(*_rows(_motor_grid(model, step_time).numbers_at(of_motor), 3))


def block_model_with(
    model: PlantModel, factors: FloatArray, sample_time: float, block: int
) -> tuple[FloatArray, FloatArray]:
    """Return the structure's model from one block of samples to the next, interpolated.

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism without factors.
    factors : ndarray, shape (3,) or (4,)
        Natural logarithms of ``FACTORS`` or of all ``MODEL_FACTORS``.
    sample_time : float
        Sample time [s].
    block : int
        Samples in a block.

    Returns
    -------
    start : ndarray, shape (4, 4)
        Map from a state to its mean over the block that begins with it.
    step : ndarray, shape (4, 6)
        Discrete structure whose sample is a block.
    """
    of_structure = _of_all(factors) * OF_STRUCTURE
    numbers = _block_grid(model, sample_time, block).numbers_at(of_structure)
    return numbers[:16].reshape(4, 4), numbers[16:].reshape(4, 6)


def _of_all(factors: FloatArray) -> FloatArray:
    """Return logarithms of ``MODEL_FACTORS``; those that are not given are of ones."""
    missing = len(MODEL_FACTORS) - factors.size
    return np.append(factors, np.zeros(missing)) if missing else factors


class _Grid:
    """The numbers of one model on the grid of factors, remembered."""

    def __init__(self, make: Callable[[Point], FloatArray], origin: Any = None) -> None:
        self._make, self.origin = make, origin
        self._made: dict[Point, FloatArray] = {}
        self._parabolas: dict[Point, list[tuple[FloatArray, FloatArray] | None]] = {}

    def numbers_at(self, factors: FloatArray) -> FloatArray:
        """Return numbers that are known on the grid, by parabolas along its axes.

        They are off by less than 5e-5 of their slopes, as if a factor were 0.005 % off. What is
        linear in the numbers, as a structure that follows a slow base, stays exact.
        """
        # A parabola is as good near its ends as in its middle: every other point will do for that.
        multiples = (factors / FACTOR_GRID).tolist()
        place: Point = tuple(2 * round(0.5 * multiple) for multiple in multiples)
        numbers = self._at(place).copy()
        for axis, (multiple, nearest) in enumerate(zip(multiples, place, strict=True)):
            off = multiple - nearest
            if off != 0.0:
                slope, curvature = self._parabola(place, axis)
                numbers += 0.5 * off * slope
                numbers += 0.5 * off * off * curvature
        return numbers

    def _parabola(self, place: Point, axis: int) -> tuple[FloatArray, FloatArray]:
        """Return twice the slope and the curvature of the numbers along an axis."""
        known = self._parabolas.setdefault(place, [None] * len(MODEL_FACTORS))
        parabola = known[axis]
        if parabola is None:
            ahead, behind = (
                self._at((*place[:axis], place[axis] + side, *place[axis + 1 :]))
                for side in (1, -1)
            )
            parabola = ahead - behind, ahead - 2 * self._at(place) + behind
            known[axis] = parabola
        return parabola

    def _at(self, place: Point) -> FloatArray:
        if place not in self._made:
            if len(self._made) == MOST_POINTS:
                self._made.clear()
                self._parabolas.clear()
            self._made[place] = self._make(place)
        return self._made[place]


@lru_cache(maxsize=MOST_GRIDS)
def _plant_grid(model: PlantModel, sample_time: float) -> _Grid:
    """Return the grid of the discrete plant."""

    def numbers(point: Point) -> FloatArray:
        changed = model_with(model, FACTOR_GRID * point)
        step = discretize_plant(changed, sample_time, quick_exponential)
        rows = [*step.motor, *step.structure, *step.contact]
        return np.array([number for row in rows for number in row], dtype=np.float64)

    return _Grid(numbers, discretize_plant(model, sample_time))


@lru_cache(maxsize=MOST_GRIDS)
def _motor_grid(model: PlantModel, step_time: float) -> _Grid:
    """Return the grid of the discrete motor."""

    def numbers(point: Point) -> FloatArray:
        motor = model_with(model, FACTOR_GRID * point).motor
        return np.array(discretize_motor(motor, step_time, quick_exponential)).ravel()

    return _Grid(numbers)


@lru_cache(maxsize=MOST_GRIDS)
def _block_grid(model: PlantModel, sample_time: float, block: int) -> _Grid:
    """Return the grid of the structure's model by blocks."""
    return _Grid(lambda point: _block_numbers(model, point, sample_time, block))


def _block_numbers(model: PlantModel, point: Point, sample_time: float, block: int) -> FloatArray:
    """Return the numbers of the structure's model by blocks at a point of the grid."""
    structure = model_with(model, FACTOR_GRID * point).structure
    sample = discretize_structure(structure, sample_time, quick_exponential)
    one_sample = np.array([row[:4] for row in sample])
    power, total = np.eye(4), np.zeros((4, 4))
    for _ in range(block):
        total += power
        # In this order, which a library's product keeps on some processors only.
        power = reduce(np.add, [one_sample[:, k, None] * power[k] for k in range(4)])
    step = discretize_structure(structure, block * sample_time, quick_exponential)
    return np.concatenate([(total / block).ravel(), np.array(step).ravel()])


def _rows(numbers: FloatArray, count: int) -> Any:
    """Return an array as `count` tuples of float."""
    return map(tuple, numbers.reshape(count, -1).tolist())
