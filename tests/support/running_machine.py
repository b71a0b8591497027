"""The motion of a lead-screw drive with everything that a real one has.

Shares no equation with the repository: 20 us steps, the current implicit, the speed explicit but
for friction and load of the screw, which are set-valued: they stop the motor within a step, or
take what they can; so does a bridge that drops with the current. Friction that yields is LuGre's.
Each integration leads by half a step, so the platform is some 40 us ahead of an exact solution,
and 60 us behind an elastic screw.
"""

import math
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from unknown_machine import LARGEST_VOLTAGE, PITCH, UnknownMachine

from bdt_plant.compilation import GIVEN, WRITTEN, compile_loop

FloatArray = NDArray[np.float64]

STEP_TIME = 2e-5
"""Time of an integration step [s]."""
PUSH_PERIOD, PUSH_TIME = 7.0, 0.05
"""Time from one push to the next, and for which it lasts [s]."""
SCALE_PERIOD = 20e-6
"""Length over which the error of the reading is periodic [m]."""
TOUCHING = 1e-12
"""Angle [rad] within which motor and screw touch: the play sets one from the other, rounded."""
CONSTANTS = (
    *("inertia", "inductance", "resistance", "torque_constant", "back_emf_constant"),
    *("viscous_friction", "coulomb_friction", "friction_at_rest", "stribeck_speed"),
    *("friction_asymmetry", "cogging", "cogs", "mass", "stiffness", "damping"),
    *("cubic_stiffness", "efficiency", "pushes_middle", "friction_along", "friction_fade"),
    *("thread_error", "guide_friction", "presliding", "bristle_damping"),
    *("upper_mass", "upper_stiffness", "amplifier_lag", "screw_stiffness"),
    *("warming", "friction_in_turn", "gap_along", "bridge_drop"),
)
"""What the loop takes, in its order."""


class RunningMachine:
    """A machine at rest that is about to move.

    Parameters
    ----------
    machine : UnknownMachine
        The machine.
    gaps : ndarray, shape (n,)
        Its gap from each sample to the next [rad].
    sampling_rate : float
        Rate of the samples [Hz]: 50 kHz by a whole number.
    seed : int
        Of the sensor's noise.
    """

    def __init__(
        self, machine: UnknownMachine, gaps: FloatArray, sampling_rate: float, seed: int
    ) -> None:
        count = len(gaps)
        self._machine, self._gaps = machine, gaps
        self._inner = round(1.0 / (sampling_rate * STEP_TIME))
        self._times = np.arange(count) / sampling_rate
        self._pushes = machine.push_force * _pushes(self._times)
        self._noise = machine.noise * np.random.default_rng(seed).standard_normal(count)
        self._late = round(machine.delay / STEP_TIME)
        # Positions of the platform at every step: a delay is no whole number of samples.
        self._positions = np.zeros(count * self._inner + 1)
        self._state = np.zeros(13)
        self._constants = np.array([float(getattr(machine, name)) for name in CONSTANTS])
        self._voltages = np.empty(count)
        self._sample = 0

    @property
    def time(self) -> float:
        """Time [s]."""
        return float(self._times[self._sample])

    def reading(self) -> float:
        """Return what the sensor reads now [m]."""
        return float(self._readings(slice(self._sample, self._sample + 1))[0])

    def hold(self, voltage: float, samples: int) -> None:
        """Go on for some samples with a command [V]."""
        count = slice(self._sample, min(self._sample + samples, len(self._gaps)))
        self._voltages[count] = voltage
        steps = self._positions[count.start * self._inner + 1 : count.stop * self._inner + 1]
        applied = _amplified(self._machine, voltage)
        gaps, pushes = self._gaps[count], self._pushes[count]
        _compiled_advance()(self._state, self._constants, applied, gaps, pushes, steps)
        self._sample = count.stop

    def telemetry(self, first: int = 0) -> FloatArray:
        """Return rows (t [s], u [V], reading [m]) from a sample to now, shape (n, 3)."""
        seen = slice(first, self._sample)
        return np.stack([self._times[seen], self._voltages[seen], self._readings(seen)], axis=1)

    @property
    def gap(self) -> float:
        """Gap now [rad], where the platform is."""
        along = self._machine.gap_along * self._positions[self._sample * self._inner]
        return float(self._gaps[self._sample] * (1.0 + along))

    def true_gaps(self) -> FloatArray:
        """Return the gap at each sample so far [rad], where the platform was, shape (n,)."""
        along = self._machine.gap_along * self.true_positions()
        return self._gaps[: self._sample] * (1.0 + along)

    def true_positions(self) -> FloatArray:
        """Return where the top platform was at each sample so far [m], shape (n,)."""
        return self._positions[: self._sample * self._inner : self._inner]

    def _readings(self, samples: slice) -> FloatArray:
        times, machine = self._times[samples], self._machine
        steps = np.arange(samples.start, samples.start + len(times)) * self._inner
        position = self._positions[np.maximum(steps - self._late, 0)]
        periodic = machine.encoder_error * np.sin(2.0 * math.pi * position / SCALE_PERIOD)
        reading = position + periodic + machine.bias + machine.drift_rate * times
        reading += self._noise[samples]
        if machine.quantum > 0.0:
            reading = np.round(reading / machine.quantum) * machine.quantum
        return reading


def _amplified(machine: UnknownMachine, voltage: float) -> float:
    if machine.amplifier_bits > 0:
        step = 2.0 * LARGEST_VOLTAGE / 2**machine.amplifier_bits
        voltage = round(voltage / step) * step
    if machine.amplifier_dead_band > 0.0:
        voltage = math.copysign(max(abs(voltage) - machine.amplifier_dead_band, 0.0), voltage)
    voltage *= 1.0 - machine.amplifier_sag * abs(voltage) / LARGEST_VOLTAGE
    return machine.amplifier_gain * voltage + machine.amplifier_offset


def _pushes(times: FloatArray) -> FloatArray:
    """Return the direction in which something pushes at each time, or zero."""
    counts, since = np.divmod(times, PUSH_PERIOD)
    return np.where((since < PUSH_TIME) & (counts > 0), (-1.0) ** counts, 0.0)


@cache
def _compiled_advance() -> Any:
    arrays = (WRITTEN, GIVEN, "float64", GIVEN, GIVEN, WRITTEN)
    return compile_loop(_advance, f"void({', '.join(arrays)})")


def _advance(  # noqa: PLR0915 - one loop, compiled as a whole
    state: FloatArray,
    constants: FloatArray,
    commanded: float,
    gaps: FloatArray,
    pushes: FloatArray,
    positions: FloatArray,
) -> None:
    inertia, inductance, resistance, per_ampere, back_emf = constants[:5]
    viscous, coulomb, at_rest, stribeck, asymmetry, cogging, cogs = constants[5:12]
    mass, stiffness, damping, cubic, efficiency, pushes_middle = constants[12:18]
    current, speed, motor, screw = state[:4]
    along_screw, fade, thread_error, guide_friction, presliding, bristle_damping = constants[18:24]
    upper_mass, upper_stiffness = mass * constants[24], stiffness * constants[25]
    beyond = max(at_rest - coulomb, 0.0)
    q2, v2, q3, v3, base_speed, time, bend, voltage = state[4:12]
    left = np.exp(-STEP_TIME / constants[26]) if constants[26] > 0.0 else 0.0
    elastic = constants[27]
    warming, in_turn, gap_along, drop = constants[28:32]
    inner = positions.size // gaps.size
    against = PITCH / efficiency if efficiency > 0.0 else 0.0
    # A screw that the load drives: below a half it is self-locking.
    along = PITCH * max(2.0 - 1.0 / efficiency, 0.0) if efficiency > 0.0 else 0.0
    held = STEP_TIME * guide_friction / mass, STEP_TIME * guide_friction / upper_mass
    base = state[12]
    for step in range(positions.size):
        half, push = 0.5 * gaps[step // inner], pushes[step // inner]
        half *= 1.0 + gap_along * PITCH * screw
        voltage = commanded + left * (voltage - commanded)
        current += STEP_TIME / inductance * (voltage - back_emf * speed)
        decay = 1.0 + STEP_TIME * resistance * (1.0 + warming * time) / inductance
        current /= decay
        # A bridge that could not drive any current against its own drop lets the motor coast.
        lost = STEP_TIME / inductance * drop / decay
        current -= min(max(current, -lost), lost)
        torque = per_ampere * current - viscous * speed - cogging * np.sin(cogs * motor)
        friction = coulomb + beyond * np.exp(-((speed / stribeck) ** 2))
        friction *= 1.0 + in_turn * np.sin(screw)
        friction *= (1.0 + along_screw * PITCH * screw) * max(1.0 - fade * time, 0.0)
        if presliding > 0.0 and coulomb > 0.0:
            bristle = coulomb / presliding
            slipping = friction / bristle
            end = slipping if speed > 0.0 else -slipping
            bent = end + (bend - end) * np.exp(-abs(speed) * STEP_TIME / slipping)
            rate = bristle_damping * np.sqrt(bristle * inertia) / STEP_TIME
            bristles = bristle * bent + rate * (bent - bend)
            torque -= (1.0 + asymmetry if bristles > 0.0 else 1.0 - asymmetry) * bristles
            bend, friction = bent, 0.0
        beam = base - q2
        load = stiffness * beam + cubic * beam**3 + damping * (base_speed - v2)
        resists = against * load if load > 0.0 else along * load
        forward = (1.0 + asymmetry) * friction
        forward += resists if motor - screw >= half - TOUCHING else 0.0
        resists = -against * load if load < 0.0 else -along * load
        backward = (1.0 - asymmetry) * friction
        backward += resists if motor - screw <= TOUCHING - half else 0.0
        free = speed + STEP_TIME / inertia * torque
        if free > 0.0:
            speed = max(free - STEP_TIME / inertia * max(forward, 0.0), 0.0)
        else:
            speed = min(free + STEP_TIME / inertia * max(backward, 0.0), 0.0)
        motor += STEP_TIME * speed
        screw, before = min(max(screw, motor - half), motor + half), base
        base = PITCH * screw + thread_error * np.sin(screw)
        if elastic > 0.0:
            base_speed += STEP_TIME / mass * (elastic * (base - before) - load)
            base = before + STEP_TIME * base_speed
        base_speed = (base - before) / STEP_TIME
        beam = base - q2
        lower = stiffness * beam + cubic * beam**3 + damping * (base_speed - v2)
        beam = q3 - q2
        upper = upper_stiffness * beam + cubic * beam**3 + damping * (v3 - v2)
        v2 += STEP_TIME * (lower + upper + pushes_middle * push) / mass
        v3 += STEP_TIME * ((1.0 - pushes_middle) * push - upper) / upper_mass
        v2 -= min(max(v2, -held[0]), held[0])
        v3 -= min(max(v3, -held[1]), held[1])
        time += STEP_TIME
        q2 += STEP_TIME * v2
        q3 += STEP_TIME * v3
        positions[step] = q3
    state[0], state[1], state[2], state[3], state[4] = current, speed, motor, screw, q2
    state[5], state[6], state[7], state[8], state[9], state[10] = v2, q3, v3, base_speed, time, bend
    state[11], state[12] = voltage, base
