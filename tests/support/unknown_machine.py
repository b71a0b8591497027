"""A lead-screw drive with everything that a real one has, and a loop around it.

Shares no equation with the repository: 20 us steps, the current implicit, the speed explicit but
for Coulomb friction, which is set-valued: it stops the motor within a step, or takes what it can.
Each integration leads by half a step, so the platform is some 40 us ahead of an exact solution.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from bdt_plant.compilation import GIVEN, WRITTEN, compile_loop

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

    def square_wave(self, time: float) -> float:
        """Return the wanted position [m] at a time [s]."""
        return self.step if int(time / self.step_time) % 2 == 0 else 0.0


class Recording(NamedTuple):
    """Telemetry rows (t [s], u [V], reading [m]), shape (n, 3), and the true gap [rad]."""

    rows: FloatArray
    gaps: FloatArray


class Controller(Protocol):
    """What closes the loop."""

    def voltage(self, error: float, dead_zone: float) -> float:
        """Return the voltage [V] for an error and half of a dead zone [m]."""


class Proportional:
    """Proportional control, which needs no dead zone.

    Parameters
    ----------
    gain : float
        Gain [V/m].
    """

    def __init__(self, gain: float) -> None:
        self._gain = gain

    def voltage(self, error: float, dead_zone: float) -> float:
        """Return the voltage [V] for an error [m]."""
        return min(max(self._gain * error, -LARGEST_VOLTAGE), LARGEST_VOLTAGE)


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


def record(
    machine: UnknownMachine,
    run: Run | None = None,
    controller: Controller | None = None,
    reference: Callable[[float], float] | None = None,
) -> Recording:
    """Run a machine in the loop.

    Parameters
    ----------
    machine : UnknownMachine
        The machine.
    run : Run, optional
        What the loop does.
    controller : Controller, optional
        What closes it: without one the paper's.
    reference : callable, optional
        Returns the wanted position [m] at a time [s]: without one there are steps.
    """
    run = Run() if run is None else run
    controller = Pid() if controller is None else controller
    reference = run.square_wave if reference is None else reference
    count = round(run.duration * run.sampling_rate)
    inner = round(1.0 / (run.sampling_rate * STEP_TIME))
    held = round(run.sampling_rate / CONTROL_RATE)
    late = round(machine.delay / STEP_TIME)
    times = np.arange(count) / run.sampling_rate
    gaps = run.first_gap + (run.last_gap - run.first_gap) * (times / run.duration) ** 2
    pushes = machine.push_force * _pushes(times)
    noise = machine.noise * np.random.default_rng(run.seed).standard_normal(count)
    state, constants = np.zeros(8), _constants(machine)
    # Positions of the platform at every step: a delay is no whole number of samples.
    positions, voltages = np.zeros(count * inner + 1), np.empty(count)
    for sample in range(0, count, held):
        time, after = times[sample], slice(sample, min(sample + held, count))
        position = positions[max(sample * inner - late, 0)]
        reading = float(_readings(machine, position, time, noise[sample]))
        dead_zone = PITCH * float(gaps[sample]) + 1e-6
        voltage = controller.voltage(reference(float(time)) - reading, dead_zone)
        voltages[after] = voltage
        steps = positions[sample * inner + 1 : after.stop * inner + 1]
        applied = _amplified(machine, voltage)
        _compiled_advance()(state, constants, applied, gaps[after], pushes[after], steps)
    seen = positions[np.maximum(np.arange(count) * inner - late, 0)]
    return Recording(
        np.stack([times, voltages, _readings(machine, seen, times, noise)], axis=1), gaps
    )


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


def _readings(machine: UnknownMachine, position: Any, time: Any, noise: Any) -> Any:
    """Return what the sensor reads, of one sample or of all."""
    periodic = machine.encoder_error * np.sin(2.0 * math.pi * position / 20e-6)
    reading = position + periodic + machine.drift_rate * time + noise
    if machine.quantum > 0.0:
        reading = np.round(reading / machine.quantum) * machine.quantum
    return reading


def _amplified(machine: UnknownMachine, voltage: float) -> float:
    if machine.amplifier_bits > 0:
        step = 2.0 * LARGEST_VOLTAGE / 2**machine.amplifier_bits
        voltage = round(voltage / step) * step
    return voltage + machine.amplifier_offset


def _pushes(times: FloatArray) -> FloatArray:
    """Return the direction in which something pushes at each time, or zero."""
    counts, since = np.divmod(times, 7.0)
    return np.where((since < 0.05) & (counts > 0), (-1.0) ** counts, 0.0)


@cache
def _compiled_advance() -> Any:
    arrays = (WRITTEN, GIVEN, "float64", GIVEN, GIVEN, WRITTEN)
    return compile_loop(_advance, f"void({', '.join(arrays)})")


def _advance(
    state: FloatArray,
    constants: FloatArray,
    voltage: float,
    gaps: FloatArray,
    pushes: FloatArray,
    positions: FloatArray,
) -> None:
    inertia, inductance, resistance, per_ampere, back_emf = constants[:5]
    viscous, coulomb, beyond, stribeck, cogging, cogs = constants[5:11]
    mass, stiffness, damping, reflected = constants[11:15]
    current, speed, motor, screw = state[:4]
    q2, v2, q3, v3 = state[4:8]
    inner = positions.size // gaps.size
    for step in range(positions.size):
        gap, push = gaps[step // inner], pushes[step // inner]
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
