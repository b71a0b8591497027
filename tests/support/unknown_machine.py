"""A lead-screw drive with everything that a real one has, and a loop around it.

Shares no equation with the repository: 20 us steps, the current implicit, the speed explicit but
for Coulomb friction, which is set-valued: it stops the motor within a step, or takes what it can.
Each integration leads by half a step, so the platform is some 40 us ahead of an exact solution.
"""

import math
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.compilation import compile_loop

FloatArray = NDArray[np.float64]

STEP_TIME = 2e-5
"""Time of an integration step [s]."""
PITCH = 1e-3 / (2.0 * math.pi)
"""Travel of the screw per angle [m/rad]."""
CONTROL_RATE = 500.0
"""Rate of the controller [Hz]."""
LARGEST_VOLTAGE = 24.0
"""Limit of the voltage [V]."""


@dataclass(frozen=True)
class UnknownMachine:
    """Constants of the mechanism; by default it is the paper's, with a good sensor.

    Torques are at the motor's shaft [N m], speeds in rad/s, everything else in SI units.
    """

    inertia: float = 5e-6
    inductance: float = 1e-3
    resistance: float = 12.0
    torque_constant: float = 0.8
    back_emf_constant: float = 0.1
    viscous_friction: float = 0.0
    coulomb_friction: float = 0.0
    friction_at_rest: float = 0.0
    """Friction of a motor that stands; the smaller of both counts as none."""
    stribeck_speed: float = 2.0
    cogging: float = 0.0
    cogs: float = 24.0
    mass: float = 5.2
    stiffness: float = 1e4
    damping: float = 36.9
    reflected_load: float = 0.0
    """Share of the structure's force that the screw hands on to the motor."""
    amplifier_offset: float = 0.0
    amplifier_bits: int = 0
    noise: float = 1e-6
    quantum: float = 1e-7
    delay: float = 0.0
    drift_rate: float = 0.0
    encoder_error: float = 0.0
    """Amplitude of an error of the reading that is periodic over 20 um."""
    push_force: float = 0.0
    """Force on the top platform for 50 ms every 7 s, to and fro."""


@dataclass(frozen=True)
class Run:
    """What the loop does."""

    duration: float = 30.0
    sampling_rate: float = 1000.0
    first_gap: float = math.radians(3.0)
    last_gap: float = math.radians(12.0)
    step: float = 5e-3
    step_time: float = 5.0
    seed: int = 1


class Recording(NamedTuple):
    """Telemetry rows (t [s], u [V], reading [m]), shape (n, 3), and the true gap [rad]."""

    rows: FloatArray
    gaps: FloatArray


class Pid:
    """PID control with a dead zone as wide as the true gap.

    The gains are those of the paper, discrete by backward differences.
    """

    PROPORTIONAL, INTEGRAL, DERIVATIVE, FILTER_TIME = 3080.0, 30800.0, -308.4, 0.074

    def __init__(self) -> None:
        self._decay = math.exp(-1.0 / (CONTROL_RATE * self.FILTER_TIME))
        self._integral = self._filtered = 0.0

    def voltage(self, error: float, dead_zone: float) -> float:
        """Return the voltage [V] for an error and half of a dead zone [m]."""
        rests = abs(error) <= dead_zone
        felt = 0.0 if rests else error
        integral = self._integral + felt / CONTROL_RATE
        self._filtered = self._decay * self._filtered + (1.0 - self._decay) * felt
        slope = (felt - self._filtered) / self.FILTER_TIME
        wanted = self.PROPORTIONAL * felt + self.INTEGRAL * integral + self.DERIVATIVE * slope
        bounded = 0.0 if rests else min(max(wanted, -LARGEST_VOLTAGE), LARGEST_VOLTAGE)
        winds_up = abs(wanted) > LARGEST_VOLTAGE and wanted * felt > 0.0
        self._integral = self._integral if winds_up else integral
        return bounded


def record(machine: UnknownMachine, run: Run | None = None) -> Recording:
    """Run a machine in the loop."""
    run = Run() if run is None else run
    count = round(run.duration * run.sampling_rate)
    inner = round(1.0 / (run.sampling_rate * STEP_TIME))
    held = round(run.sampling_rate / CONTROL_RATE)
    late = round(machine.delay / STEP_TIME)
    times = np.arange(count) / run.sampling_rate
    gaps = run.first_gap + (run.last_gap - run.first_gap) * (times / run.duration) ** 2
    noise = machine.noise * np.random.default_rng(run.seed).standard_normal(count)
    state, constants = np.zeros(8), _constants(machine)
    # Positions of the platform at every step: a delay is no whole number of samples.
    positions = np.zeros(count * inner + 1)
    rows, pid, voltage = np.empty((count, 3)), Pid(), 0.0
    for sample, time in enumerate(times.tolist()):
        position = float(positions[max(sample * inner - late, 0)])
        reading = _reading(machine, position, time) + float(noise[sample])
        if machine.quantum > 0.0:
            reading = round(reading / machine.quantum) * machine.quantum
        if sample % held == 0:
            target = run.step if int(time / run.step_time) % 2 == 0 else 0.0
            dead_zone = PITCH * float(gaps[sample]) + 1e-6
            voltage = pid.voltage(target - reading, dead_zone)
        rows[sample] = time, voltage, reading
        applied = _amplified(machine, voltage)
        push = machine.push_force * _push_at(time)
        after = positions[sample * inner + 1 : (sample + 1) * inner + 1]
        _compiled_advance()(state, constants, applied, float(gaps[sample]), push, after)
    return Recording(rows, gaps)


def _constants(machine: UnknownMachine) -> FloatArray:
    most = max(machine.friction_at_rest, machine.coulomb_friction)
    return np.array(
        [
            machine.inertia,
            machine.inductance,
            machine.resistance,
            machine.torque_constant,
            machine.back_emf_constant,
            machine.viscous_friction,
            machine.coulomb_friction,
            most - machine.coulomb_friction,
            machine.stribeck_speed,
            machine.cogging,
            machine.cogs,
            machine.mass,
            machine.stiffness,
            machine.damping,
            machine.reflected_load,
        ]
    )


def _reading(machine: UnknownMachine, position: float, time: float) -> float:
    periodic = machine.encoder_error * math.sin(2.0 * math.pi * position / 20e-6)
    return position + periodic + machine.drift_rate * time


def _amplified(machine: UnknownMachine, voltage: float) -> float:
    if machine.amplifier_bits > 0:
        step = 2.0 * LARGEST_VOLTAGE / 2**machine.amplifier_bits
        voltage = round(voltage / step) * step
    return voltage + machine.amplifier_offset


def _push_at(time: float) -> float:
    count, since = divmod(time, 7.0)
    return (-1.0) ** count if since < 0.05 and count > 0 else 0.0


@cache
def _compiled_advance() -> Any:
    given, written = "Array(float64, 1, 'C', readonly=True)", "Array(float64, 1, 'C')"
    return compile_loop(_advance, f"void({written}, {given}, float64, float64, float64, {written})")


def _advance(
    state: FloatArray,
    constants: FloatArray,
    voltage: float,
    gap: float,
    push: float,
    positions: FloatArray,
) -> None:
    inertia, inductance, resistance, per_ampere, back_emf = constants[:5]
    viscous, coulomb, beyond, stribeck, cogging, cogs = constants[5:11]
    mass, stiffness, damping, reflected = constants[11:15]
    current, speed, motor, screw = state[:4]
    q2, v2, q3, v3 = state[4:8]
    for step in range(positions.size):
        current += STEP_TIME / inductance * (voltage - back_emf * speed)
        current /= 1.0 + STEP_TIME * resistance / inductance
        load = reflected * PITCH * stiffness * (q2 - PITCH * screw)
        torque = per_ampere * current - viscous * speed + load - cogging * np.sin(cogs * motor)
        free = speed + STEP_TIME / inertia * torque
        friction = coulomb + beyond * np.exp(-((speed / stribeck) ** 2))
        taken = min(STEP_TIME / inertia * friction, abs(free))
        speed = free - taken if free > 0.0 else free + taken
        motor += STEP_TIME * speed
        before = screw
        screw = min(max(screw, motor - 0.5 * gap), motor + 0.5 * gap)
        base, base_speed = PITCH * screw, PITCH * (screw - before) / STEP_TIME
        lower = stiffness * (base - q2) + damping * (base_speed - v2)
        upper = stiffness * (q3 - q2) + damping * (v3 - v2)
        v2 += STEP_TIME * (lower + upper) / mass
        v3 += STEP_TIME * (push - upper) / mass
        q2 += STEP_TIME * v2
        q3 += STEP_TIME * v3
        positions[step] = q3
    state[0], state[1], state[2], state[3] = current, speed, motor, screw
    state[4], state[5], state[6], state[7] = q2, v2, q3, v3
