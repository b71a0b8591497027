"""How many periods of cogging a motor has in a turn, from what is left unexplained by a fit.

Cogging is a wave of the motor's angle. For small ones the position depends on its two parts
linearly, so for each number of periods the likelihood tells what they would explain, beside all
that the fit has found already.
"""

from functools import cache
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.compilation import compile_with_steps
from bdt_plant.elementary_functions import FULL_TURN, sine_of_turns
from bdt_twin.fit_doubt import covariance_inflation, huber_weights
from bdt_twin.fit_result import Fit
from bdt_twin.fixed_order import dot, product, weighted_products
from bdt_twin.forward_model import StretchResponse
from bdt_twin.information import inverse
from bdt_twin.innovations import NoiseLevels, Whitening
from bdt_twin.machine_knowledge import EFFECT_SPREAD, EFFECTS
from bdt_twin.noise_levels import quiet
from bdt_twin.resisted_model import rotated
from bdt_twin.resisted_plant import COGGED_SPEED
from bdt_twin.structure_responses import structure_responses
from bdt_twin.window_loop import SMALLEST_SPEED
from bdt_twin.window_model import WindowModel

FloatArray = NDArray[np.float64]

MOST_COGS = 48
"""Largest number of periods in a turn."""
FEWEST_COGS = 4
"""Smallest number of periods in a turn: fewer are like a load that changes slowly."""


class CoggingEvidence(NamedTuple):
    """Number of periods in a turn that explains most, and the gain of log-likelihood by it."""

    cogs: int
    gain: float


def cogging_evidence(window: WindowModel, fit: Fit) -> CoggingEvidence:
    """Return the number of periods in a turn for which there is most evidence.

    Parameters
    ----------
    window : WindowModel
        Model and data, without cogging.
    fit : Fit
        Its fit.
    """
    jacobian = window.jacobian(fit.unknowns, fit.responses)
    slopes, weights = _weighted_slopes(window, jacobian, fit.whitening, fit.levels)
    # What the prior pulls at, from the step that the fit did not make.
    told = product(slopes, weights * fit.innovations)
    pulled = told - product(weighted_products(slopes, weights) + fit.prior, fit.pending)
    # A walk of the motor may be cogging that nobody has looked for, and would hide it.
    levels = quiet(fit.levels)
    whitening = fit.whitening.with_levels(levels)
    slopes, weights = _weighted_slopes(window, jacobian, whitening, levels)
    innovations = whitening.innovations
    information = weighted_products(slopes, weights) + fit.prior
    covariance = inverse(information)
    pending = product(covariance, product(slopes, weights * innovations) - pulled)
    tightness = 1.0 / EFFECT_SPREAD[EFFECTS.index("cogging_sine")] ** 2
    best = CoggingEvidence(0, 0.0)
    waves = np.ascontiguousarray(whitening.apply(_wave_slopes(window, fit)))
    for number, (sine, cosine) in enumerate(waves.reshape(-1, 2, waves.shape[1])):
        weighted = [weights * sine, weights * cosine]
        coupling = [product(slopes, each) for each in weighted]
        left = [
            dot(each, innovations) - dot(with_others, pending)
            for each, with_others in zip(weighted, coupling, strict=True)
        ]
        solved = [product(covariance, with_others) for with_others in coupling]
        a = dot(weighted[0], sine) + tightness - dot(coupling[0], solved[0])
        b = dot(weighted[0], cosine) - dot(coupling[0], solved[1])
        c = dot(weighted[1], cosine) + tightness - dot(coupling[1], solved[1])
        determinant = a * c - b * b
        if a > 0.0 and determinant > 0.0:
            gain = c * left[0] * left[0] - 2.0 * b * left[0] * left[1] + a * left[1] * left[1]
            gain *= 0.5 / determinant
            if gain > best.gain:
                best = CoggingEvidence(FEWEST_COGS + number, gain)
    return best


def _weighted_slopes(
    window: WindowModel, jacobian: FloatArray, whitening: Whitening, levels: NoiseLevels
) -> tuple[FloatArray, FloatArray]:
    """Return the slopes of the innovations, and their weights."""
    innovations = whitening.innovations
    inflation = covariance_inflation(innovations, levels, window.block_rate)
    return whitening.apply(jacobian), huber_weights(innovations) / inflation


def _wave_slopes(window: WindowModel, fit: Fit) -> FloatArray:
    """Return the slopes of the position for both parts of each wave, shape (2 waves, blocks)."""
    step, per_volt = window.block_step(fit.unknowns), window.travel_per_volt(fit.unknowns)
    stretches = []
    for number, run in enumerate(fit.responses):
        turns = window.screw_turns(fit.unknowns, number)
        waves = _waves(run, window.block, window.block_rate)
        bases = [
            -per_volt * part
            for index, (sine, cosine) in enumerate(waves)
            for part in rotated(sine, cosine, -turns * (FEWEST_COGS + index))
        ]
        stretches.append(structure_responses(step, np.stack(bases, axis=1)))
    return np.concatenate(stretches).T


def _waves(run: StretchResponse, block: int, block_rate: float) -> FloatArray:
    """Return the time integrals of both parts of each wave up to the last contact [s].

    Returns
    -------
    ndarray, shape (waves, 2, blocks)
    """
    sums = np.zeros((run.contact.size, MOST_COGS - FEWEST_COGS + 1, 2))
    compiled_waves()(run.motor_angle, run.contact, 1.0 / (block_rate * block), sums)
    waves: FloatArray = np.ascontiguousarray(sums.transpose(1, 2, 0))
    return waves


@cache
def compiled_waves() -> Any:
    """Return the loop of the waves' integrals, compiled."""

    def signature() -> Any:
        # Imported here, because it is absent on many a small computer.
        types = import_module("numba").types
        given = types.Array(types.float64, 1, "C", readonly=True)
        return given, given, types.float64, types.Array(types.float64, 3, "C")

    return compile_with_steps(_wave_loop, [sine_of_turns], signature)


def _wave_loop(sources: str) -> Any:
    def wave_loop(
        motor_angle: FloatArray, contact: FloatArray, sample_time: float, sums: FloatArray
    ) -> None:
        _ = sources
        blocks, waves, _ = sums.shape
        block = motor_angle.size // blocks
        now, last = np.zeros((waves, 2)), np.zeros((waves, 2))
        before = motor_angle[0]
        for number in range(blocks):
            for k in range(number * block, (number + 1) * block):
                angle = motor_angle[k]
                speed = abs(angle - before) / sample_time
                before = angle
                if SMALLEST_SPEED < speed < COGGED_SPEED:
                    turns = angle / FULL_TURN
                    sine, cosine = sine_of_turns(turns), sine_of_turns(turns + 0.25)
                    first = FEWEST_COGS * turns
                    wave_sine, wave_cosine = sine_of_turns(first), sine_of_turns(first + 0.25)
                    for wave in range(waves):
                        now[wave, 0] += sample_time * wave_sine
                        now[wave, 1] += sample_time * wave_cosine
                        # The next wave is turned by the angle once more.
                        wave_sine, wave_cosine = (
                            wave_sine * cosine + wave_cosine * sine,
                            wave_cosine * cosine - wave_sine * sine,
                        )
            for wave in range(waves):
                for part in range(2):
                    held = last[wave, part]
                    if contact[number] > 0.0:
                        last[wave, part] = now[wave, part]
                    sums[number, wave, part] = 0.5 * (held + last[wave, part])

    return wave_loop
