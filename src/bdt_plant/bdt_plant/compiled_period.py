"""The plant over one control period, compiled: the floats of the plain function in less time."""

from functools import cache
from importlib import import_module
from typing import Any

from bdt_plant.compilation import compile_with_steps
from bdt_plant.plant import (
    AT_REST,
    DiscretePlant,
    FloatArray,
    HoldPeriod,
    PlantModel,
    PlantState,
    discretize_plant,
    hold_period,
)


@cache
def compiled_hold_period() -> HoldPeriod:
    """Return :func:`bdt_plant.plant.hold_period`, compiled where numba is installed."""

    def signature() -> Any:
        # Imported here, because it is absent on many a small computer.
        numba = import_module("numba")
        types = numba.types
        given = types.Array(types.float64, 1, "C", readonly=True)
        written = types.Array(types.float64, 1, "C")
        step = discretize_plant(PlantModel(), 2e-4)
        return numba.typeof(AT_REST), types.float64, given, numba.typeof(step), written

    period: HoldPeriod = compile_with_steps(_period, [hold_period], signature)
    return period


def _period(sources: str) -> HoldPeriod:
    def period(
        state: PlantState,
        voltage: float,
        gaps: FloatArray,
        step: DiscretePlant,
        positions: FloatArray,
    ) -> PlantState:
        _ = sources
        return hold_period(state, voltage, gaps, step, positions)

    return period
