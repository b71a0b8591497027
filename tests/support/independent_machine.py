"""A machine that shares no code with the twin: 50 kHz, semi-implicit, with set-valued friction."""

import math
from dataclasses import dataclass, fields

import numba
import numpy as np

from bdt_controller.commissioning import level_at

RATE, STEPS = 5000, 10
"""Samples per second [Hz], and steps of the integration per sample."""
PITCH = 1e-3 / (2 * math.pi)


@dataclass(frozen=True)
class Machine:
    """Constants in SI units; gain of the controller [V/m]."""

    inertia: float = 5e-6
    inductance: float = 1e-3
    resistance: float = 12.0
    torque_constant: float = 0.8
    back_emf_constant: float = 0.1
    friction: float = 10e-3
    mass: float = 5.2
    stiffness: float = 1e4
    damping: float = 36.9
    gap: float = math.radians(12.0)
    offset: float = 20e-3
    delay: float = 0.5e-3
    drift: float = 0.0
    noise: float = 1e-6
    controller_gain: float = 900.0
    voltage_limit: float = 24.0

    @property
    def friction_voltage(self):
        return self.friction / self.torque_constant * self.resistance


CONSTANTS = [each.name for each in fields(Machine) if each.name not in ("delay", "drift", "noise")]


def commissioning_reference(duration, travel=5e-3, speed=20e-3):
    times = np.arange(round(duration * RATE)) / RATE
    return np.array([travel * level_at(time, travel / speed) for time in times])


def telemetry(machine, reference, seed=1):
    """Return telemetry rows (t [s], u [V], q3 [m]) of a loop with a proportional controller."""
    late = machine.delay * RATE * STEPS
    assert late == round(late)
    constants = tuple(float(getattr(machine, name)) for name in CONSTANTS)
    rows = np.empty((reference.size, 3))
    rows[:, 0] = np.arange(reference.size) / RATE
    noise = machine.noise * np.random.default_rng(seed).standard_normal(reference.size)
    noise += machine.drift * rows[:, 0]
    _run(constants, reference, noise, round(late), rows)
    rows[:, 2] = np.round(rows[:, 2], 7)
    return rows


@numba.njit(cache=True)
def _run(constants, reference, noise, late, rows):
    (
        inertia,
        inductance,
        resistance,
        torque,
        emf,
        friction,
        mass,
        k,
        c,
        gap,
        offset,
        gain,
        most,
    ) = constants
    h = 1.0 / (RATE * STEPS)
    current, speed, motor, screw = 0.0, 0.0, 0.0, 0.0
    q2, v2, q3, v3 = 0.0, 0.0, 0.0, 0.0
    line = np.zeros(late + 1)
    number = 0
    for sample in range(reference.size):
        line[number % line.size] = q3
        reading = line[(number - late) % line.size] + noise[sample]
        voltage = min(max(gain * (reference[sample] - reading), -most), most)
        rows[sample, 1], rows[sample, 2] = voltage, reading
        for _ in range(STEPS):
            current += h / inductance * (voltage + offset - emf * speed)
            current /= 1.0 + h * resistance / inductance
            speed += h / inertia * torque * current
            # Friction takes what it can of the momentum, and no more than there is.
            speed = math.copysign(max(abs(speed) - h / inertia * friction, 0.0), speed)
            motor += h * speed
            before = screw
            screw = min(max(screw, motor - 0.5 * gap), motor + 0.5 * gap)
            base, base_speed = PITCH * screw, PITCH * (screw - before) / h
            f2 = k * (base - q2) + c * (base_speed - v2) + k * (q3 - q2) + c * (v3 - v2)
            f3 = k * (q2 - q3) + c * (v2 - v3)
            v2 += h / mass * f2
            v3 += h / mass * f3
            q2 += h * v2
            q3 += h * v3
            number += 1
            line[number % line.size] = q3
