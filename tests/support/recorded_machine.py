"""What a machine does in a loop, recorded: steps of a PID with a dead zone, or anything else."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from running_machine import FloatArray, RunningMachine
from unknown_machine import LARGEST_VOLTAGE, PITCH, UnknownMachine

CONTROL_RATE = 500.0
"""Rate of the controller [Hz]."""


@dataclass(frozen=True)
class Run:
    """What the loop does.

    The gap grows faster and faster, or jumps from its first to its last size at a time [s].
    """

    duration: float = 30.0
    sampling_rate: float = 1000.0
    first_gap: float = math.radians(3.0)
    last_gap: float = math.radians(12.0)
    step: float = 5e-3
    step_time: float = 5.0
    seed: int = 1
    jumps_at: float | None = None

    def gaps(self) -> FloatArray:
        """Return the gap [rad] at each sample."""
        count = round(self.duration * self.sampling_rate)
        shares = np.arange(count) / count
        if self.jumps_at is None:
            shares = shares**2
        else:
            shares = (shares >= self.jumps_at / self.duration).astype(float)
        return self.first_gap + (self.last_gap - self.first_gap) * shares

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
    gaps, held = run.gaps(), round(run.sampling_rate / CONTROL_RATE)
    running = RunningMachine(machine, gaps, run.sampling_rate, run.seed)
    for sample in range(0, gaps.size, held):
        error = reference(running.time) - running.reading()
        dead_zone = PITCH * float(gaps[sample]) + 1e-6
        running.hold(controller.voltage(error, dead_zone), held)
    return Recording(running.telemetry(), gaps)
