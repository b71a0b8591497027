"""Slopes of the position with respect to the effects that act through the motor."""

import numpy as np
from numpy.typing import NDArray

from bdt_plant.structure import DiscreteStructure, StructureState
from bdt_twin.forward_model import simulate_structure
from bdt_twin.machine_knowledge import EFFECTS
from bdt_twin.resisted_model import rotated
from bdt_twin.window_loop import DRIVES

FloatArray = NDArray[np.float64]


def add_drive_slopes(
    jacobian: FloatArray,
    effects: FloatArray,
    drives: FloatArray,
    cog_turns: float,
    travel: FloatArray,
    step: DiscreteStructure,
) -> None:
    """Write the rows of the effects that act through the motor.

    The motor settles within milliseconds, so it turns as fast as the voltage tells.

    Parameters
    ----------
    jacobian : ndarray, shape (effects, blocks)
        Written.
    effects : ndarray, shape (effects,)
        ``machine_knowledge.EFFECTS``.
    drives : ndarray, shape (drives, blocks)
        What has moved the motor; see ``StretchResponse.drives``.
    cog_turns : float
        Part of a cog's period at which the stretch begins.
    travel : ndarray, shape (blocks,)
        Speed of the screw for a volt [m/(V s)], zero before it has moved.
    step : DiscreteStructure
        The structure's model from block to block.
    """
    of = dict(zip(DRIVES, drives, strict=True))
    sine, cosine = rotated(of["cogging_sine"], of["cogging_cosine"], -cog_turns)
    acts = {
        "friction_voltage": -of["friction"],
        "voltage_offset": of["offset"],
        "excess_voltage": -of["excess"],
        "stribeck_speed": -effects[EFFECTS.index("excess_voltage")] * of["stribeck_speed"],
        "load_voltage": -of["load"],
        "cogging_sine": -sine,
        "cogging_cosine": -cosine,
    }
    at_rest = StructureState(0.0, 0.0, 0.0, 0.0)
    for name, turned in acts.items():
        if turned.any():
            jacobian[EFFECTS.index(name)] = simulate_structure(step, at_rest, travel * turned)
