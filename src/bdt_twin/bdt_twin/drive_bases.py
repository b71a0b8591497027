"""Bases of the structure for the slopes with respect to the effects that act through the motor."""

import numpy as np
from numpy.typing import NDArray

from bdt_twin.machine_knowledge import EFFECTS
from bdt_twin.resisted_model import rotated
from bdt_twin.window_loop import DRIVES

FloatArray = NDArray[np.float64]


def drive_bases(
    effects: FloatArray, drives: FloatArray, cog_turns: float, travel: FloatArray
) -> FloatArray:
    """Return how far each effect moves the screw's end, for a unit of it.

    The motor settles within milliseconds, so it turns as fast as the voltage tells.

    Parameters
    ----------
    effects : ndarray, shape (effects,)
        ``machine_knowledge.EFFECTS``.
    drives : ndarray, shape (drives, blocks)
        What has moved the motor; see ``StretchResponse.drives``.
    cog_turns : float
        Part of a cog's period at which the stretch begins.
    travel : ndarray, shape (blocks,)
        Speed of the screw for a volt [m/(V s)], zero before it has moved.

    Returns
    -------
    ndarray, shape (effects, blocks)
        Zero for effects that do not act through the motor.
    """
    of = dict(zip(DRIVES, drives, strict=True))
    effect = dict(zip(EFFECTS, effects.tolist(), strict=True))
    sine, cosine = rotated(of["cogging_sine"], of["cogging_cosine"], -cog_turns)
    acts = {
        "friction_voltage": -of["friction"],
        "voltage_offset": of["offset"],
        "excess_voltage": -of["excess"],
        "stribeck_speed": -effect["excess_voltage"] * of["stribeck_speed"],
        "load_voltage": -of["load"],
        "cogging_sine": -sine,
        "cogging_cosine": -cosine,
        "friction_growth": -effect["friction_voltage"] * of["growth"],
        "friction_slope": -effect["friction_voltage"] * of["slope"],
        "yield_angle": -effect["friction_voltage"] * of["yielding"],
        "voltage_lag": of["lag"],
    }
    bases = np.zeros((len(EFFECTS), travel.size))
    for name, turned in acts.items():
        bases[EFFECTS.index(name)] = travel * turned
    return bases
