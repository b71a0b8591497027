"""Position of platform 3 for many bases side by side, which is what the slopes of a window are.

The recursion is that of :func:`bdt_plant.structure.structure_step`, to the last bit. Innermost are
sums over all bases, which the processor works on at once.
"""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bdt_plant.compilation import compile_with_steps
from bdt_plant.structure import StructureState

FloatArray = NDArray[np.float64]


def structure_responses(
    step: ArrayLike, bases: FloatArray, states: FloatArray | None = None
) -> FloatArray:
    """Return position q3 of platform 3 for bases that move as given (eq. 3).

    Parameters
    ----------
    step : array_like, shape (4, 6) or (n, 4, 6)
        Discrete structure for the spacing of the instants, one for all bases or one for each.
    bases : ndarray, shape (instants, n)
        Position d of the lead screw's end [m].
    states : ndarray, shape (n, 4), optional
        States at the first instant; None for structures at rest at zero.

    Returns
    -------
    ndarray, shape (instants, n)
    """
    first = np.zeros((bases.shape[1], 4)) if states is None else states
    return _run(step, bases, np.array(first.T, order="C"))


def structure_after(step: ArrayLike, state: StructureState, base: FloatArray) -> StructureState:
    """Return the state of the structure at the last instant of a base that moves as given (eq. 3).

    Parameters
    ----------
    step : array_like, shape (4, 6)
        Discrete structure for the spacing of `base`.
    state : StructureState
        State at the first instant.
    base : ndarray, shape (instants,)
        Position d of the lead screw's end [m].
    """
    states = np.array(state)[:, None]
    _run(step, base[:, None], states)
    return StructureState(*states[:, 0].tolist())


def _run(step: ArrayLike, bases: FloatArray, states: FloatArray) -> FloatArray:
    """Return the positions; `states`, shape (4, n), become those at the last instant."""
    steps, positions = np.array(step), np.empty(bases.shape)
    if steps.ndim == 2:
        compiled_responses()(steps, np.ascontiguousarray(bases), states, positions)
    else:
        steps = np.ascontiguousarray(steps.transpose(1, 2, 0))
        compiled_responses_of_each()(steps, np.ascontiguousarray(bases), states, positions)
    return positions


@cache
def compiled_responses() -> Any:
    """Return the loop of :func:`structure_responses` for one structure, compiled."""
    return compile_with_steps(_responses_of_all, [of_all], lambda: _signature(2))


@cache
def compiled_responses_of_each() -> Any:
    """Return the loop of :func:`structure_responses` for one structure each, compiled."""
    return compile_with_steps(_responses_of_each, [of_each], lambda: _signature(3))


COMPILED = (compiled_responses, compiled_responses_of_each)
"""What to call before the first data wait."""


def of_all(step: FloatArray, row: int, column: int, _base: int) -> float:
    """Return a number of the structure that all bases have; a step function."""
    return step[row, column]  # type: ignore[no-any-return]


def of_each(steps: FloatArray, row: int, column: int, base: int) -> float:
    """Return a number of the structure of one base; a step function."""
    return steps[row, column, base]  # type: ignore[no-any-return]


def _signature(dimensions: int) -> str:
    given, written = "Array(float64, {}, 'C', readonly=True)", "Array(float64, 2, 'C')"
    return f"void({given.format(dimensions)}, {given.format(2)}, {written}, {written})"


def _responses_of_all(sources: str) -> Any:
    return _responses_around(of_all, sources)


def _responses_of_each(sources: str) -> Any:
    return _responses_around(of_each, sources)


def _responses_around(number: Any, sources: str) -> Any:
    def responses(
        steps: FloatArray, bases: FloatArray, states: FloatArray, positions: FloatArray
    ) -> None:
        _ = sources
        instants, count = bases.shape
        follows = np.empty((4, count))
        for k in range(instants):
            if k > 0:
                for i in range(4):
                    for n in range(count):
                        follows[i, n] = (
                            number(steps, i, 0, n) * states[0, n]
                            + number(steps, i, 1, n) * states[1, n]
                            + number(steps, i, 2, n) * states[2, n]
                            + number(steps, i, 3, n) * states[3, n]
                            + number(steps, i, 4, n) * bases[k - 1, n]
                            + number(steps, i, 5, n) * bases[k, n]
                        )
                for i in range(4):
                    for n in range(count):
                        states[i, n] = follows[i, n]
            for n in range(count):
                positions[k, n] = states[2, n]

    return responses
