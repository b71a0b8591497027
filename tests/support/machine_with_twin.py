"""The controller and the digital twin around a machine that shares no equation with them."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from running_machine import PUSH_PERIOD, PUSH_TIME, FloatArray, RunningMachine
from unknown_machine import LARGEST_VOLTAGE, UnknownMachine

from bdt_analysis.metrics.reference_steps import find_steps
from bdt_analysis.metrics.step_analysis import StepSummary, summarize_step
from bdt_controller.control_law import INITIAL_CONTROL, control_step, discretize_control, switched
from bdt_controller.notch import NO_NOTCH
from bdt_controller.pid import PidGains
from bdt_plant.plant import PlantModel
from bdt_plant.pushes import PushParameters
from bdt_study.design.tuned_gains import TUNED_GAINS
from bdt_study.evaluation.trial import MARGIN, InstrumentedEstimator, is_pushed_while_judged
from bdt_study.simulation.offline_twin import OfflineTwin
from bdt_twin.dead_zone_tolerance import DeadZoneRule
from bdt_twin.decider import create_decider
from bdt_twin.decision import ControllerGains
from bdt_twin.decision_settings import DecisionSettings
from bdt_twin.estimator import Estimate
from bdt_twin.link import PAPER_LINK, DelayedLink
from bdt_twin.output_error import OutputErrorEstimator
from bdt_twin.output_error_settings import OutputErrorSettings
from bdt_twin.reconfiguration import Reconfigurator

SAMPLING_RATE, CONTROL_RATE = 5000.0, 500.0
HOLD = round(SAMPLING_RATE / CONTROL_RATE)
BATCH = 50
"""Control periods in a batch of telemetry: 0.1 s."""
PITCH = PlantModel().lead_screw.pitch


def sine(turns: float) -> float:
    """Return a wave from 0 to 1 and back in a turn that begins at rest."""
    return 0.5 - 0.5 * math.cos(2.0 * math.pi * turns)


def triangle(turns: float) -> float:
    """Return a wave from 0 to 1 and back in a turn, evenly."""
    return 1.0 - abs(1.0 - 2.0 * (turns % 1.0))


@dataclass(frozen=True, eq=False)
class Course:
    """What a machine has to do, and how its gap grows meanwhile.

    Attributes
    ----------
    gaps : ndarray, shape (n,)
        Gap at each sample of 5 kHz [rad].
    height : float
        The reference is this high [m] and zero in turn.
    step_time : float
        Time for which it stays, or in which it goes from one to the other [s].
    wave : callable or None
        How it goes, as a function of full periods from 0 to 1; None for steps.
    first : float
        What the reference is more than that [m].
    seed : int
        Of the sensor's noise.
    decision : str
        How the twin decides, as in its parameter ``decision.kind``.
    """

    gaps: FloatArray
    height: float = 5e-3
    step_time: float = 10.0
    wave: Callable[[float], float] | None = None
    first: float = 0.0
    seed: int = 0
    decision: str = "equation_9"

    @property
    def periods(self) -> int:
        """Number of control periods."""
        return len(self.gaps) // HOLD

    def reference(self, time: float) -> float:
        """Return the wanted position [m] at a time [s]."""
        if self.wave is None:
            share = float(int(time / self.step_time + 1e-9) % 2 == 0)
        else:
            share = self.wave(0.5 * time / self.step_time)
        return self.first + self.height * share


@dataclass(frozen=True, eq=False)
class MachineRun:
    """What became of it.

    Attributes
    ----------
    steps : list of StepSummary
        Steps of the reference, by the true position.
    estimates : list of Estimate
        What the twin said.
    gaps : ndarray, shape (n,)
        True gap at each sample, where the platform was [rad].
    window_times : list of float
        Processor time of each estimate [s].
    first_dead_zone : float
        Time from which on there was a dead zone [s].
    """

    steps: list[StepSummary]
    estimates: list[Estimate]
    gaps: FloatArray
    window_times: list[float]
    first_dead_zone: float


class _Controller:
    """The controller of the repository, whose gains may change."""

    def __init__(self) -> None:
        self._law = discretize_control(PidGains(), 1.0 / CONTROL_RATE)
        self._state = INITIAL_CONTROL

    def set_gains(self, gains: ControllerGains, error: float) -> None:
        law = discretize_control(gains.pid, 1.0 / CONTROL_RATE, gains.notch)
        self._state = switched(self._state, error, self._law, law)
        self._law = law

    def voltage(self, error: float, tolerance: float, offset: float) -> float:
        self._state, voltage = control_step(
            self._state, error, tolerance, self._law, LARGEST_VOLTAGE, offset
        )
        return voltage


def run_with_twin(machine: UnknownMachine, course: Course) -> MachineRun:
    """Run a machine with a controller and a twin that know the paper's constants alone.

    Parameters
    ----------
    machine : UnknownMachine
        The machine.
    course : Course
        What it does.
    """
    estimator = InstrumentedEstimator(
        OutputErrorEstimator(PlantModel(), OutputErrorSettings(), SAMPLING_RATE), noise=0.0
    )
    decider = create_decider(
        DecisionSettings(
            kind=course.decision, reconfigure_gains=True, voltage_limit=LARGEST_VOLTAGE
        ),
        PlantModel(),
        ControllerGains(PidGains(), NO_NOTCH),
        TUNED_GAINS,
        estimator,
        DelayedLink(PAPER_LINK).expected_delay,
        MARGIN.horizon,
    )
    reconfigurator = Reconfigurator(DeadZoneRule(MARGIN, PITCH), DelayedLink(PAPER_LINK))
    twin = OfflineTwin(estimator, reconfigurator, decider, compensates=True)
    running = RunningMachine(machine, course.gaps, SAMPLING_RATE, course.seed)
    controller = _Controller()
    tolerances, offsets = np.zeros(course.periods), np.zeros(course.periods)
    stamps = np.rint(np.arange(course.periods) * 1e9 / CONTROL_RATE).astype(np.int64)
    for first in range(0, course.periods, BATCH):
        part = slice(first, min(first + BATCH, course.periods))
        switches = twin.reconfigure(stamps[part], tolerances[part], offsets[part])
        for period in range(part.start, part.stop):
            error = course.reference(running.time) - running.reading()
            if period - first in switches:
                controller.set_gains(switches[period - first], error)
            running.hold(controller.voltage(error, tolerances[period], offsets[period]), HOLD)
        twin.take_telemetry(running.telemetry(first * HOLD))
    set_at = np.flatnonzero(tolerances)
    begin = float(set_at[0]) / CONTROL_RATE if set_at.size else math.inf
    gaps = running.true_gaps()
    return MachineRun(_steps(course, running), twin.estimates, gaps, estimator.times, begin)


def steps_with_true_gap(
    machine: UnknownMachine, course: Course, share: float = 1.0
) -> list[StepSummary]:
    """Return the steps of the same machine with eq. 9 for a share of the true gap of each instant.

    Parameters
    ----------
    machine : UnknownMachine
        The machine.
    course : Course
        What it does.
    share : float
        The share; 0 for no dead zone.
    """
    running = RunningMachine(machine, course.gaps, SAMPLING_RATE, course.seed)
    controller = _Controller()
    for _ in range(course.periods):
        error = course.reference(running.time) - running.reading()
        tolerance = share * PITCH * running.gap
        running.hold(controller.voltage(error, tolerance, 0.0), HOLD)
    return _steps(course, running)


def is_pushed(machine: UnknownMachine, course: Course, step: StepSummary) -> bool:
    """Tell whether something pushes the machine while a step of its course is judged."""
    pushes = PushParameters(machine.push_force, PUSH_TIME, PUSH_PERIOD)
    return is_pushed_while_judged(step.t_start_s, course.step_time, pushes)


def _steps(course: Course, running: RunningMachine) -> list[StepSummary]:
    if course.wave is not None:
        return []
    rows = running.telemetry()
    rows[:, 2] = running.true_positions()
    edges = np.arange(0.0, course.periods / CONTROL_RATE, course.step_time)
    references = np.array([(edge, course.reference(edge)) for edge in edges])
    found = find_steps(references, rows, 1.0 / SAMPLING_RATE)
    return [summarize_step(step, rows, 1.0 / SAMPLING_RATE) for step in found if not step.cut]
