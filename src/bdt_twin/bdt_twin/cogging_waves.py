"""How waves of the motor's angle move the position: cogging, whose number of periods is unknown."""

from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_plant.compilation import compile_with_steps
from bdt_plant.elementary_functions import FULL_TURN, float_exponential, sine_of_turns
from bdt_twin.fit_result import Fit
from bdt_twin.friction_change import TURNING
from bdt_twin.machine_knowledge import EFFECTS, USUAL_STRIBECK_SPEED
from bdt_twin.resisted_model import rotated
from bdt_twin.resisted_plant import COGGED_SPEED, FAST, slope_left, slow_share, steepness
from bdt_twin.structure_responses import structure_responses
from bdt_twin.window_model import WindowModel

FloatArray = NDArray[np.float64]

FEWEST_COGS, MOST_COGS = 4, 48
"""Smallest and largest number of periods in a turn: fewer are like a load that changes slowly."""
NUMBERS = tuple(range(FEWEST_COGS, MOST_COGS + 1))
"""Numbers of periods in a turn."""


def wave_slopes(window: WindowModel, fit: Fit) -> FloatArray:
    """Return the slopes of the position for both parts of each wave of ``NUMBERS``.

    Parameters
    ----------
    window : WindowModel
        Model and data.
    fit : Fit
        Their fit.

    Returns
    -------
    ndarray, shape (2 waves, blocks)
        Slopes for sine and cosine in turn [m/V].
    """
    step, per_volt = window.block_step(fit.unknowns), window.travel_per_volt(fit.unknowns)
    effect = dict(zip(EFFECTS, fit.unknowns.effects.tolist(), strict=True))
    slow = USUAL_STRIBECK_SPEED * float_exponential(effect["stribeck_speed"])
    steep = steepness(effect["excess_voltage"], slow, window.pitch / per_volt)
    sample_time = 1.0 / window.sampling_rate
    stretches = []
    for number, run in enumerate(fit.responses):
        turns = window.screw_turns(fit.unknowns, number)
        waves = np.zeros((run.contact.size, len(NUMBERS), 2))
        compiled_waves()(run.motor_angle, run.contact, sample_time, slow, steep, waves)
        bases = [
            -per_volt * part
            for cogs, (sine, cosine) in zip(NUMBERS, waves.transpose(1, 2, 0), strict=True)
            for part in rotated(sine, cosine, -turns * cogs)
        ]
        stretches.append(structure_responses(step, np.stack(bases, axis=1)))
    return np.concatenate(stretches).T


@cache
def compiled_waves() -> Any:
    """Return the loop of the waves' integrals up to the last contact [s], compiled.

    It writes them in an array of shape (blocks, waves, 2).
    """

    def signature() -> Any:
        # Imported here, because it is absent on many a small computer.
        types = import_module("numba").types
        given = types.Array(types.float64, 1, "C", readonly=True)
        numbers = (types.float64 for _ in range(3))
        return given, given, *numbers, types.Array(types.float64, 3, "C")

    return compile_with_steps(_wave_loop, STEPS, signature)


STEPS = (sine_of_turns, slow_share, slope_left)
"""Step functions that the loop of the waves calls."""


def _wave_loop(sources: str) -> Any:
    def wave_loop(
        motor_angle: FloatArray,
        contact: FloatArray,
        sample_time: float,
        stribeck_speed: float,
        steep: float,
        sums: FloatArray,
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
                if TURNING < speed < COGGED_SPEED:
                    ratio, felt = speed / stribeck_speed, sample_time
                    if ratio < FAST:
                        felt /= slope_left(ratio, slow_share(ratio), steep)
                    turns = angle / FULL_TURN
                    sine, cosine = sine_of_turns(turns), sine_of_turns(turns + 0.25)
                    first = FEWEST_COGS * turns
                    wave_sine, wave_cosine = sine_of_turns(first), sine_of_turns(first + 0.25)
                    for wave in range(waves):
                        now[wave, 0] += felt * wave_sine
                        now[wave, 1] += felt * wave_cosine
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
