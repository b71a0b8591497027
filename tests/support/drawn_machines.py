"""Machines by name, and machines drawn at random, each with what it has to do."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from machine_with_twin import SAMPLING_RATE, Course
from unknown_machine import FloatArray, UnknownMachine

PAPER_TIME, PAPER_GAP = 120.0, math.radians(30.0)
"""Duration [s] and last gap [rad] of the paper's scenario."""
DRAWN_TIME = 60.0
"""Duration of a machine that is drawn [s]."""
PER_RUN = 1.0 / PAPER_TIME
"""Makes a drift [m/s] of what it is over the paper's run [m]."""

ROWS = {
    "nothing, noise of 2 um": UnknownMachine(noise=2e-6),
    "Coulomb friction 2 mN m": UnknownMachine(coulomb_friction=2e-3),
    "Coulomb friction 10 mN m": UnknownMachine(coulomb_friction=10e-3),
    "Coulomb friction 40 mN m": UnknownMachine(coulomb_friction=40e-3),
    "10 mN m, 16 mN m at rest": UnknownMachine(coulomb_friction=10e-3, friction_at_rest=16e-3),
    "cogging 3 mN m, 24 in a turn": UnknownMachine(cogging=3e-3),
    "reading 1 ms late": UnknownMachine(delay=1e-3),
    "stiffening beams, 2e6 N/m^3": UnknownMachine(cubic_stiffness=2e6),
    "pushes of 2 N": UnknownMachine(push_force=2.0),
    "drift of 20 um": UnknownMachine(drift_rate=20e-6 * PER_RUN),
    "amplifier offset 50 mV": UnknownMachine(amplifier_offset=0.05),
    "viscous friction 1e-5 N m s": UnknownMachine(viscous_friction=1e-5),
    "load, efficiency 0.4": UnknownMachine(efficiency=0.4),
    "amplifier of 12 bits": UnknownMachine(amplifier_bits=12),
    "sensor bias 50 um": UnknownMachine(bias=50e-6),
    "periodic error 0.5 um": UnknownMachine(encoder_error=0.5e-6),
    "everyday": UnknownMachine(
        resistance=12.0 * 1.08,
        back_emf_constant=0.1 * 1.04,
        viscous_friction=1e-5,
        coulomb_friction=8e-3,
        friction_at_rest=10e-3,
        cogging=1e-3,
        mass=5.2 * 1.02,
        stiffness=1e4 * 0.98,
        damping=36.9 * 1.1,
        efficiency=0.4,
        amplifier_offset=0.02,
        amplifier_bits=12,
        delay=2e-4,
        drift_rate=5e-6 * PER_RUN,
        encoder_error=0.2e-6,
    ),
}
"""One effect at a time, and all of them."""


class Trial(NamedTuple):
    """A machine and what it has to do."""

    machine: UnknownMachine
    course: Course


def named(name: str, seed: int) -> Trial:
    """Return a machine of ``ROWS`` in the paper's scenario."""
    shares = np.arange(round(PAPER_TIME * SAMPLING_RATE)) / (PAPER_TIME * SAMPLING_RATE)
    decision = "simulate" if name == "everyday" else "equation_9"
    return Trial(ROWS[name], Course(PAPER_GAP * shares**2, seed=seed, decision=decision))


class _Draws:
    """Sizes of effects, drawn evenly between a share of the largest and the largest."""

    def __init__(self, generator: np.random.Generator, least: float) -> None:
        self._generator, self._least = generator, least

    def size(self, largest: float) -> float:
        return largest * float(self._generator.uniform(self._least, 1.0))

    def signed(self, largest: float) -> float:
        return self.size(largest) * float(self._generator.choice((-1.0, 1.0)))

    def between(self, low: float, high: float) -> float:
        return float(self._generator.uniform(low, high))

    def one_of(self, *choices: float) -> float:
        return float(self._generator.choice(choices))


def everyday(generator: np.random.Generator) -> UnknownMachine:
    """Return a machine with a bit of everything."""
    draws = _Draws(generator, 0.5)
    coulomb = draws.size(8e-3)
    return UnknownMachine(
        resistance=12.0 * (1.0 + draws.signed(0.08)),
        back_emf_constant=0.1 * (1.0 + draws.signed(0.04)),
        viscous_friction=draws.size(1e-5),
        coulomb_friction=coulomb,
        friction_at_rest=coulomb * (1.0 + draws.size(0.25)),
        stribeck_speed=draws.between(1.0, 4.0),
        cogging=draws.size(1e-3),
        cogs=draws.one_of(12.0, 24.0, 36.0),
        mass=5.2 * (1.0 + draws.signed(0.02)),
        stiffness=1e4 * (1.0 + draws.signed(0.02)),
        damping=36.9 * (1.0 + draws.signed(0.1)),
        efficiency=draws.between(0.2, 0.9),
        amplifier_offset=draws.signed(0.02),
        amplifier_bits=12,
        delay=draws.size(2e-4),
        drift_rate=draws.signed(5e-6 * PER_RUN),
        encoder_error=draws.size(2e-7),
    )


def unknown(generator: np.random.Generator) -> UnknownMachine:
    """Return a machine with all effects, each from nothing to much."""
    draws = _Draws(generator, 0.0)
    coulomb = draws.size(0.04)
    return UnknownMachine(
        resistance=12.0 * (1.0 + draws.signed(0.08)),
        back_emf_constant=0.1 * (1.0 + draws.signed(0.05)),
        viscous_friction=draws.size(2e-5),
        coulomb_friction=coulomb,
        friction_at_rest=coulomb * (1.0 + draws.size(0.6)),
        stribeck_speed=draws.between(1.0, 4.0),
        friction_asymmetry=draws.signed(0.2),
        cogging=draws.size(3e-3),
        cogs=draws.one_of(12.0, 24.0, 36.0),
        mass=5.2 * (1.0 + draws.signed(0.02)),
        stiffness=1e4 * (1.0 + draws.signed(0.02)),
        damping=36.9 * (1.0 + draws.signed(0.15)),
        cubic_stiffness=draws.size(2e6),
        efficiency=draws.between(0.2, 0.9),
        amplifier_gain=1.0 + draws.signed(0.02),
        amplifier_offset=draws.signed(0.05),
        amplifier_bits=12,
        delay=draws.size(1e-3),
        bias=draws.signed(50e-6),
        drift_rate=draws.signed(20e-6 * PER_RUN),
        encoder_error=draws.size(5e-7),
        push_force=draws.size(1.0),
        pushes_middle=draws.one_of(0.0, 1.0) == 1.0,
    )


def cogging(generator: np.random.Generator) -> UnknownMachine:
    """Return a machine with nothing but cogging."""
    draws = _Draws(generator, 0.0)
    return UnknownMachine(cogging=draws.size(3e-3), cogs=draws.one_of(12.0, 24.0, 36.0))


def worn(times: FloatArray, generator: np.random.Generator) -> FloatArray:
    """Return a gap that stays, or grows evenly or faster and faster, to 15 to 30 degrees."""
    first, last = np.radians((generator.uniform(0.0, 10.0), generator.uniform(15.0, 30.0)))
    exponent = float(generator.choice((0.0, 1.0, generator.uniform(1.0, 3.0))))
    return first + (last - first) * (times / DRAWN_TIME) ** exponent


def jumped(times: FloatArray, generator: np.random.Generator) -> FloatArray:
    """Return a gap that jumps once, by 3 to 10 degrees."""
    first, jump = np.radians((generator.uniform(5.0, 15.0), generator.uniform(3.0, 10.0)))
    return first + jump * (times >= generator.uniform(20.0, 45.0))


def breathing(times: FloatArray, generator: np.random.Generator) -> FloatArray:
    """Return a gap that rises and falls by 3 to 6 degrees in 30 to 70 s."""
    mean, swing = np.radians((generator.uniform(8.0, 18.0), generator.uniform(3.0, 6.0)))
    turns = times / generator.uniform(30.0, 70.0) + generator.uniform(0.0, 1.0)
    return mean + swing * np.sin(2.0 * math.pi * turns)


class Kind(NamedTuple):
    """How machines are drawn."""

    machine: Callable[[np.random.Generator], UnknownMachine]
    gaps: Callable[[FloatArray, np.random.Generator], FloatArray] = worn
    decision: str = "simulate"


KINDS = {
    "everyday": Kind(everyday),
    "unknown": Kind(unknown),
    "cogging": Kind(cogging, decision="equation_9"),
    "everyday, gap jumps": Kind(everyday, jumped),
    "everyday, gap rises and falls": Kind(everyday, breathing),
}
"""What is drawn."""


def drawn(name: str, seed: int) -> Trial:
    """Return the machine of a kind that a seed draws, in steps of 4 to 10 mm and 5 to 12 s."""
    kind = KINDS[name]
    generator = np.random.default_rng((seed, *name.encode()))
    times = np.arange(round(DRAWN_TIME * SAMPLING_RATE)) / SAMPLING_RATE
    course = Course(
        kind.gaps(times, generator),
        height=float(generator.uniform(4e-3, 10e-3)),
        step_time=float(generator.uniform(5.0, 12.0)),
        seed=seed,
        decision=kind.decision,
    )
    return Trial(kind.machine(generator), course)
