"""What a window is expected to be like after the fit of the one before."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.structure import StructureState
from bdt_twin.fit_result import Fit
from bdt_twin.fixed_order import mean
from bdt_twin.forward_model import StretchResponse
from bdt_twin.machine_knowledge import CHANGING, EFFECTS, grown_friction
from bdt_twin.noise_levels import is_restless
from bdt_twin.structure_responses import structure_after
from bdt_twin.unknowns import Unknowns
from bdt_twin.window_model import WindowModel
from bdt_twin.window_search import initial_conditions_at_rest

FloatArray = NDArray[np.float64]

PUSH_RINGS = 3.0
"""Time after a push in which the platforms are not where the simulation has them [s]."""


class Predecessor(NamedTuple):
    """A window before, from which the fit of the next one begins.

    Attributes
    ----------
    window : WindowModel
        Model and data.
    fit : Fit
        The model fitted to the data; it may leave the gap unknown.
    growth : float
        Growth rate of the gap at its end [rad/s].
    """

    window: WindowModel
    fit: Fit
    growth: float


def predicted_unknowns(window: WindowModel, last: Predecessor) -> Unknowns:
    """Return the unknowns with which the last fit would go on in a window.

    A stretch that begins within the data of the last window begins in the state that the
    mechanism had there; another one is expected to begin at rest. Of a motor that walks the
    simulation tells no more than where in the gap it is.

    Parameters
    ----------
    window : WindowModel
        Model and data.
    last : Predecessor
        The window before, and its fit.
    """
    before, fit, knots = last.window, last.fit, window.knots
    beyond = np.maximum(knots - before.knots[-1], 0.0)
    # Both windows' knots are multiples of the spacing, so that nothing is rounded.
    gaps = np.interp(knots, before.knots, fit.unknowns.gaps) + last.growth * beyond
    gaps = np.maximum(gaps, 0.0)
    initial_conditions = initial_conditions_at_rest(window)
    walks = is_restless(fit.levels)
    for beginning, stretch in zip(initial_conditions, window.stretches, strict=True):
        begins = stretch.first / window.sampling_rate
        for number, (old, run) in enumerate(zip(before.stretches, fit.responses, strict=True)):
            # A window before may have been simulated at another rate.
            sample = round(begins * before.sampling_rate - old.first)
            if 0 <= sample < run.relative_angle.size:
                half = 0.5 * window.gap_at(gaps, begins)
                state = _state_at(before, fit.unknowns, number, run, sample, half)
                if walks:
                    beginning[0] = state[0]
                    continue
                beginning[:] = state
                if _rings(last, number, sample):
                    continue
                # By what the machine has wandered from its simulation in the meantime.
                seen = slice(sample, sample + before.block)
                beginning[1] += mean(old.position[seen] - run.position[seen])
    effects = fit.unknowns.effects.copy()
    friction, growth = map(EFFECTS.index, CHANGING)
    effects[friction] *= grown_friction(effects[growth], window.span[1] - before.span[1])
    return Unknowns(gaps, fit.unknowns.factors, initial_conditions, effects)


def _rings(last: Predecessor, number: int, sample: int) -> bool:
    """Tell whether something has pushed a platform shortly before a sample of a stretch."""
    window, pushed = last.window, last.fit.pushed
    block = sample // window.block
    first = max(block - round(PUSH_RINGS * window.block_rate), 0)
    begins = sum(stretch.position.size for stretch in window.stretches[:number]) // window.block
    return bool(pushed[begins + first : begins + block + 1].any())


def _state_at(
    window: WindowModel,
    unknowns: Unknowns,
    number: int,
    run: StretchResponse,
    sample: int,
    half_gap: float,
) -> FloatArray:
    """Return the ``INITIAL_CONDITION`` of a stretch that begins at a sample of a simulation."""
    _, offset, *structure = unknowns.initial_conditions[number].tolist()
    screw = run.motor_angle[: sample + 1] - run.relative_angle[: sample + 1]
    base = window.pitch * screw
    state = structure_after(window.sample_step(unknowns), StructureState(*structure), base)
    end = float(base[-1])
    share = float(run.relative_angle[sample]) / half_gap if half_gap > 0.0 else 0.0
    drifted = float(unknowns.effects[EFFECTS.index("drift")]) * sample / window.sampling_rate
    return np.array(
        [
            min(max(share, -1.0), 1.0),
            offset + end + drifted,
            state.q2 - end,
            state.q2_velocity,
            state.q3 - end,
            state.q3_velocity,
        ]
    )


def without_growth(window: WindowModel, last: Predecessor, predicted: Unknowns) -> Unknowns:
    """Return a prediction for a gap that no longer grows since the last window could tell it.

    Parameters
    ----------
    window : WindowModel
        Model and data.
    last : Predecessor
        The window before, and its fit, in which the screw reverses.
    predicted : Unknowns
        What :func:`predicted_unknowns` returns.
    """
    last_seen = last.window.reversals(last.fit.responses)[-1]
    known = np.minimum(window.knots, last_seen)
    return replace(predicted, gaps=np.interp(known, window.knots, predicted.gaps))
