"""Random closed loops with a growing gap, each with all controllers that are compared."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from bdt_controller.reference import ReferenceProfile
from bdt_plant.gap_profile import GapProfile, gaps_at
from bdt_plant.plant import PlantModel, Sampling
from bdt_study.engine.function_map import mapped
from bdt_study.engine.job import Engine
from bdt_study.evaluation.case import Case
from bdt_study.evaluation.cases import CASES, draw_scenario
from bdt_study.evaluation.trial import judged_steps
from bdt_study.simulation.closed_loop import (
    Scenario,
    discrete_loop,
    initial_state,
    sample_inputs,
    signals_for,
    trajectory_of,
)
from bdt_study.simulation.loop_kernel import run_kernel
from bdt_study.simulation.loop_model import LoopInputs
from bdt_study.tuning.robust_design import ControllerDesign
from bdt_twin.dead_zone_tolerance import DeadZoneSettings

FloatArray = NDArray[np.float64]

HARSH = next(case for case in CASES if case.name == "harsh")
CONDITIONS = replace(HARSH, gain_error=0.0, mechanics_error=0.0, damping_error=0.0)
"""Noise, gaps and references of the random loops; the mechanism is drawn from ranges."""

STREAM = 20_261_122
"""Sets the draws of the mechanism apart from those of the scenario around it."""

LEAD = 2.0
"""How far a dead zone is ahead of the gap [s]: delay of the link and time to the next one."""

KEPT = ("u", "q3")


@dataclass(frozen=True)
class Tried:
    """A controller with a rule for its dead zone.

    Attributes
    ----------
    design : ControllerDesign
        The controller.
    dead_zone : DeadZoneSettings
        Ratio and margin count; the gap is taken as known, `LEAD` seconds ahead.
    """

    design: ControllerDesign
    dead_zone: DeadZoneSettings


@dataclass(frozen=True)
class LoopOutcome:
    """What a loop of 80 s gives.

    Attributes
    ----------
    limit_cycles : int
        Number of steps that end in a limit cycle.
    settling_times : tuple of float
        Of each step [s]; infinite for one that does not settle.
    overshoots : tuple of float
        Of each step [% of its height].
    worst_bias : float
        Largest bias of all steps [% of the height].
    voltage_peak : float
        Largest voltage [V].
    """

    limit_cycles: int
    settling_times: tuple[float, ...]
    overshoots: tuple[float, ...]
    worst_bias: float
    voltage_peak: float


def run_loops(
    engine: Engine,
    models: Sequence[PlantModel],
    tried: Sequence[Tried],
    seeds: Sequence[int],
    control_rate: float,
) -> Iterator[list[LoopOutcome]]:
    """Iterate over what each controller makes of each random loop.

    Parameters
    ----------
    engine : Engine
        What works on it.
    models : sequence of PlantModel
        Mechanisms, of which each loop draws one.
    tried : sequence of Tried
        Controllers and rules.
    seeds : sequence of int
        Numbers of the loops.
    control_rate : float
        Rate of measurements [Hz].

    Yields
    ------
    list of LoopOutcome
        For each of `tried`, loop by loop in the order of `seeds`.
    """
    trial = partial(run_loop, models, tried, control_rate=control_rate)
    yield from mapped(engine, trial, seeds)


def run_loop(
    models: Sequence[PlantModel], tried: Sequence[Tried], seed: int, control_rate: float
) -> list[LoopOutcome]:
    """Return what each controller makes of a random loop.

    Parameters
    ----------
    models : sequence of PlantModel
        Mechanisms, of which the loop draws one.
    tried : sequence of Tried
        Controllers and rules.
    seed : int
        Number of the loop.
    control_rate : float
        Rate of measurements [Hz].
    """
    scenario = draw_loop(CONDITIONS, models, seed)
    # Samples stay about as long. Times a power of two, any rate divides its product exactly.
    samples = 2 ** max(round(math.log2(scenario.sampling.sampling_rate / control_rate)), 0)
    sampling = Sampling(sampling_rate=samples * control_rate, control_rate=control_rate)
    scenario = replace(scenario, sampling=sampling)
    inputs = sample_inputs(scenario)
    gap = scenario.gap
    if not isinstance(gap, GapProfile):
        raise TypeError("the gap of a random loop has a profile")
    times = np.arange(scenario.control_steps) / scenario.sampling.control_rate
    ahead = gaps_at(gap, np.minimum(times + LEAD, scenario.duration))
    outcomes = []
    for one in tried:
        rule = one.dead_zone
        pitch = scenario.model.lead_screw.pitch
        tolerances = pitch * (rule.ratio * ahead + rule.margin)
        loop = replace(scenario, gains=one.design.gains, notch=one.design.notch)
        outcomes.append(_outcome(loop, inputs._replace(tolerances=tolerances)))
    return outcomes


def draw_loop(conditions: Case, models: Sequence[PlantModel], seed: int) -> Scenario:
    """Return a random scenario with one of some mechanisms.

    Parameters
    ----------
    conditions : Case
        Noise and gap; its deviations are not used.
    models : sequence of PlantModel
        Mechanisms.
    seed : int
        Number of the scenario.
    """
    generator = np.random.default_rng((seed, STREAM))
    model = models[int(generator.integers(len(models)))]
    return replace(draw_scenario(conditions, seed), model=model)


def _outcome(scenario: Scenario, inputs: LoopInputs) -> LoopOutcome:
    signals = signals_for(scenario, KEPT)
    run_kernel(initial_state(scenario, inputs), discrete_loop(scenario), inputs, signals)
    loop = trajectory_of(scenario, inputs, signals, KEPT)
    steps = [
        step
        for step in judged_steps(scenario, loop, inputs.tolerances)
        if step.limit_cycle is not None
    ]
    settled = [step.settling_time_s for step in steps]
    biases = [abs(step.bias_percent_of_amplitude or 0.0) for step in steps]
    return LoopOutcome(
        sum(bool(step.limit_cycle) for step in steps),
        tuple(np.inf if time is None else time for time in settled),
        tuple(_overshoots(scenario, loop.q3)),
        max(biases, default=0.0),
        float(np.abs(loop.u).max()),
    )


def _overshoots(scenario: Scenario, position: FloatArray) -> Iterator[float]:
    """Iterate over how far the platform goes beyond each level [% of the height of the step]."""
    reference = scenario.reference
    if not isinstance(reference, ReferenceProfile):
        raise TypeError("the reference of a random loop is a square wave")
    length = round(reference.step_time * scenario.sampling.sampling_rate)
    height = reference.first - reference.second
    for number in range(position.size // length):
        part = position[number * length : (number + 1) * length]
        upward = number % 2 == 0
        level = reference.first if upward else reference.second
        beyond = float(part.max() - level) if upward else float(level - part.min())
        yield 100.0 * max(beyond, 0.0) / height
