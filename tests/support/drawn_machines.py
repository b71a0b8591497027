"""Machines by name, and machines drawn at random, each with what it has to do."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from machine_with_twin import SAMPLING_RATE, Course, sine, triangle
from running_machine import FloatArray
from unknown_machine import EVERYDAY, PER_RUN, UnknownMachine

from bdt_study.evaluation.machine_effects import Draws, MachineEffects
from bdt_study.evaluation.machines import MACHINES

PAPER_TIME, PAPER_GAP = 120.0, math.radians(30.0)
"""Duration [s] and last gap [rad] of the paper's scenario."""
DRAWN_TIME = 60.0
"""Duration of a machine that is drawn [s]."""

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
    "all at once": EVERYDAY,
}
"""One effect at a time, and all of them, small."""


class Trial(NamedTuple):
    """A machine and what it has to do."""

    machine: UnknownMachine
    course: Course


def named(name: str, seed: int) -> Trial:
    """Return a machine of ``ROWS`` in the paper's scenario."""
    shares = np.arange(round(PAPER_TIME * SAMPLING_RATE)) / (PAPER_TIME * SAMPLING_RATE)
    decision = "simulate" if name == "all at once" else "equation_9"
    return Trial(ROWS[name], Course(PAPER_GAP * shares**2, seed=seed, decision=decision))


def machine_with(
    effects: MachineEffects, generator: np.random.Generator, gain: float = 0.0, bias: float = 0.0
) -> UnknownMachine:
    """Return a machine with effects up to those of a case of `bdt evaluate`.

    Parameters
    ----------
    effects : MachineEffects
        Largest sizes; what is zero is not drawn.
    generator : numpy.random.Generator
        What they are drawn from.
    gain, bias : float
        Largest deviation of the amplifier's gain, as a fraction, and bias of the sensor [m].
    """
    draws = Draws(generator, effects.least)

    def size(largest: float) -> float:
        return draws.size(largest) if largest else 0.0

    def signed(largest: float) -> float:
        return draws.signed(largest) if largest else 0.0

    coulomb, nominal = size(effects.friction), UnknownMachine()
    return UnknownMachine(
        resistance=nominal.resistance * (1.0 + signed(effects.resistance_error)),
        back_emf_constant=nominal.back_emf_constant * (1.0 + signed(effects.gain_error)),
        viscous_friction=size(effects.viscous_friction),
        coulomb_friction=coulomb,
        friction_at_rest=coulomb * (1.0 + size(effects.stribeck)),
        stribeck_speed=draws.between(1.0, 4.0) if effects.stribeck else nominal.stribeck_speed,
        friction_asymmetry=signed(effects.friction_asymmetry),
        cogging=size(effects.cogging),
        cogs=float(draws.one_of(12, 24, 36)),
        mass=nominal.mass * (1.0 + signed(effects.mechanics_error)),
        stiffness=nominal.stiffness * (1.0 + signed(effects.mechanics_error)),
        damping=nominal.damping * (1.0 + signed(effects.damping_error)),
        cubic_stiffness=size(effects.cubic_stiffness),
        efficiency=draws.between(0.2, 0.9) if effects.load else 0.0,
        amplifier_gain=1.0 + signed(gain),
        amplifier_offset=signed(effects.offset),
        amplifier_bits=12 if effects.resolution else 0,
        delay=size(effects.delay),
        bias=signed(bias),
        drift_rate=signed(effects.drift),
        encoder_error=size(effects.periodic_error),
        push_force=size(effects.push),
        pushes_middle=bool(draws.one_of(0, 1)) if effects.push else False,
    )


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
    wave: Callable[[float], float] | None = None
    first: float = 0.0


EFFECTS = {case.name: case.effects for case in MACHINES}
everyday = partial(machine_with, EFFECTS["everyday"])
unknown = partial(machine_with, EFFECTS["unknown_machine"], gain=0.02, bias=50e-6)
cogging = partial(machine_with, EFFECTS["cogging"])


def slight_friction(generator: np.random.Generator, **constants: float) -> UnknownMachine:
    """Return a machine with some friction, and constants that the estimator has no name for."""
    effects = MachineEffects(friction=8e-3, gain_error=0.03, damping_error=0.15)
    return replace(machine_with(effects, generator), **constants)


def yielding(
    kind: Callable[[np.random.Generator], UnknownMachine], generator: np.random.Generator
) -> UnknownMachine:
    """Return a machine whose friction yields by 0.02 to 2 degrees of the motor before it slides."""
    machine = kind(generator)
    angle = math.radians(float(np.exp(generator.uniform(math.log(0.02), math.log(2.0)))))
    return replace(machine, presliding=angle, bristle_damping=float(generator.uniform(0.0, 0.3)))


def lagging(
    kind: Callable[[np.random.Generator], UnknownMachine], generator: np.random.Generator
) -> UnknownMachine:
    """Return a machine whose amplifier follows its command with 0.3 to 3 ms."""
    lag = float(np.exp(generator.uniform(math.log(3e-4), math.log(3e-3))))
    return replace(kind(generator), amplifier_lag=lag)


def laden(
    kind: Callable[[np.random.Generator], UnknownMachine], generator: np.random.Generator
) -> UnknownMachine:
    """Return a machine whose top platform has 0.7 to 1.8 times the mass of the other."""
    return replace(kind(generator), upper_mass=float(np.exp(generator.uniform(-0.36, 0.59))))


def other_in_all(
    kind: Callable[[np.random.Generator], UnknownMachine], generator: np.random.Generator
) -> UnknownMachine:
    """Return a machine with a payload, an amplifier that lags and a thread that is off."""
    machine = laden(partial(lagging, kind), generator)
    return replace(machine, thread_error=float(generator.uniform(0.0, 3e-6)))


def slight(**constants: float) -> Kind:
    """Return the kind of machines with slight friction and some constants."""
    return Kind(partial(slight_friction, **constants), decision="equation_9")


KINDS = {
    "everyday": Kind(everyday),
    "unknown": Kind(unknown),
    "cogging": Kind(cogging, decision="equation_9"),
    "everyday, gap jumps": Kind(everyday, jumped),
    "everyday, gap rises and falls": Kind(everyday, breathing),
    "everyday, sines": Kind(everyday, wave=sine),
    "everyday, triangles": Kind(everyday, wave=triangle),
    "everyday, sines from 20 mm": Kind(everyday, wave=sine, first=20e-3),
    "unknown, sines": Kind(unknown, wave=sine),
    "unknown, triangles": Kind(unknown, wave=triangle),
    "unknown, sines from 20 mm": Kind(unknown, wave=sine, first=20e-3),
    "slight friction": slight(),
    "friction fades by 10 %": slight(friction_fade=0.1 / DRAWN_TIME),
    "friction grows by 10 % in 10 mm": slight(friction_along=10.0),
    "thread off by 1 um": slight(thread_error=1e-6),
    "friction yields by 0.05 deg": slight(presliding=math.radians(0.05)),
    "friction yields by 0.2 deg": slight(presliding=math.radians(0.2)),
    "friction yields by 1 deg": slight(presliding=math.radians(1.0)),
    "everyday, friction yields": Kind(partial(yielding, everyday)),
    "unknown, friction yields": Kind(partial(yielding, unknown)),
    "top platform 30 % heavier": slight(upper_mass=1.3),
    "middle platform 30 % heavier": slight(mass=1.3 * 5.2, upper_mass=1.0 / 1.3),
    "upper beams 20 % softer": slight(upper_stiffness=0.8),
    "screw of 1 N/um": slight(screw_stiffness=1e6),
    "screw of 0.2 N/um": slight(screw_stiffness=2e5),
    "everyday, payload": Kind(partial(laden, everyday)),
    "unknown, payload": Kind(partial(laden, unknown)),
    "everyday, all": Kind(partial(other_in_all, everyday)),
    "unknown, all": Kind(partial(other_in_all, unknown)),
    "friction differs by 20 % in a turn": slight(friction_in_turn=0.2),
    "resistance rises by 10 %": slight(warming=0.1 / DRAWN_TIME),
    "gap larger by 10 % at 10 mm": slight(gap_along=10.0),
    "gap smaller by 30 % at 10 mm": slight(gap_along=-30.0),
    "dead band of 0.1 V": slight(amplifier_dead_band=0.1),
    "dead band of 0.5 V": slight(amplifier_dead_band=0.5),
    "gain sags by 10 %": slight(amplifier_sag=0.1),
    "bridge drops 0.2 V": slight(bridge_drop=0.2),
    "bridge drops 1 V": slight(bridge_drop=1.0),
    "guides with 0.1 N": slight(guide_friction=0.1),
    "twice the inertia": slight(inertia=10e-6),
    "12 times the inductance": slight(inductance=12e-3),
    "amplifier lags by 0.5 ms": slight(amplifier_lag=5e-4),
    "amplifier lags by 1 ms": slight(amplifier_lag=1e-3),
    "amplifier lags by 2 ms": slight(amplifier_lag=2e-3),
    "everyday, amplifier lags": Kind(partial(lagging, everyday)),
    "unknown, amplifier lags": Kind(partial(lagging, unknown)),
}
"""What is drawn."""


def drawn(name: str, seed: int) -> Trial:
    """Return the machine of a kind that a seed draws, in steps of 4 to 10 mm and 5 to 12 s.

    One that follows a wave goes there and back in 4 to 12 s.
    """
    kind = KINDS[name]
    generator = np.random.default_rng((seed, *name.encode()))
    times = np.arange(round(DRAWN_TIME * SAMPLING_RATE)) / SAMPLING_RATE
    course = Course(
        kind.gaps(times, generator),
        height=float(generator.uniform(4e-3, 10e-3)),
        step_time=float(
            generator.uniform(5.0, 12.0) if kind.wave is None else generator.uniform(2.0, 6.0)
        ),
        wave=kind.wave,
        first=kind.first,
        seed=seed,
        decision=kind.decision,
    )
    return Trial(kind.machine(generator), course)
