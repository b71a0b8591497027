"""The plant over one control period, compiled: the floats of the plain function in less time."""

from collections.abc import Callable
from functools import cache
from importlib import import_module
from typing import Any

from bdt_plant.compilation import compile_with_steps
from bdt_plant.machine import (
    MACHINE_AT_REST,
    discretize_machine,
    hold_machine_period,
)
from bdt_plant.plant import (
    AT_REST,
    FloatArray,
    HoldPeriod,
    PlantModel,
    Sampling,
    discretize_plant,
    hold_period,
)
from bdt_plant.unnamed_states import named_machine, named_plant, unnamed_machine, unnamed_plant


def compiled_period_of(model: PlantModel) -> Any:
    """Return the compiled function that advances a mechanism by some samples."""
    return compiled_hold_period() if model.is_piecewise_linear else compiled_machine_period()


@cache
def compiled_hold_period() -> HoldPeriod:
    """Return :func:`bdt_plant.plant.hold_period`, compiled where numba is installed."""
    step = discretize_plant(PlantModel(), 2e-4)
    steps = (hold_period, unnamed_plant)
    compiled = compile_with_steps(_period, steps, lambda: _signature(AT_REST, step))
    period: HoldPeriod = _naming(named_plant, compiled)
    return period


@cache
def compiled_machine_period() -> Any:
    """Return :func:`bdt_plant.machine.hold_machine_period`, compiled where numba is installed."""
    step = discretize_machine(PlantModel(), Sampling())
    steps = (hold_machine_period, unnamed_machine)
    compiled = compile_with_steps(_machine_period, steps, lambda: _signature(MACHINE_AT_REST, step))
    return _naming(named_machine, compiled)


def _naming(named: Callable[[Any], Any], compiled: Callable[..., Any]) -> Any:
    def period(
        state: Any, voltage: float, gaps: FloatArray, step: Any, positions: FloatArray
    ) -> Any:
        return named(compiled(state, voltage, gaps, step, positions))

    return period


def _signature(state: Any, step: Any) -> Any:
    # Imported here, because it is absent on many a small computer.
    numba = import_module("numba")
    types = numba.types
    given = types.Array(types.float64, 1, "C", readonly=True)
    written = types.Array(types.float64, 1, "C")
    return numba.typeof(state), types.float64, given, numba.typeof(step), written


def _period(sources: str) -> Any:
    return _period_around(hold_period, unnamed_plant, sources)


def _machine_period(sources: str) -> Any:
    return _period_around(hold_machine_period, unnamed_machine, sources)


def _period_around(hold: Any, unnamed: Any, sources: str) -> Any:
    def period(
        state: Any, voltage: float, gaps: FloatArray, step: Any, positions: FloatArray
    ) -> Any:
        _ = sources
        return unnamed(hold(state, voltage, gaps, step, positions))

    return period
