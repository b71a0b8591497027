"""The closed loop offline: a scenario in, its trajectory out, one by one or many over the cores."""

import os
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from bdt_controller.notch import NO_NOTCH, NotchFilter
from bdt_controller.pid import PidGains
from bdt_controller.reference import ReferenceProfile
from bdt_plant.actuator import IDEAL_ACTUATOR, ActuatorParameters, amplifier_of
from bdt_plant.gap_profile import GapProfile
from bdt_plant.lead_screw import screw_end
from bdt_plant.machine import MACHINE_AT_REST, DiscreteMachine
from bdt_plant.plant import AT_REST, PlantModel, Sampling
from bdt_plant.sensor import IDEAL_SENSOR, SensorParameters, discretize_sensor, noise_sequence
from bdt_study.simulation.loop_kernel import SIMULATED, allocate, compiled_loop, run_kernel
from bdt_study.simulation.loop_model import (
    IDEAL,
    DiscreteLoop,
    LoopInputs,
    LoopState,
    discretize_loop,
    loop_at_rest,
)
from bdt_study.simulation.sampled_signals import Signal, sampled

FloatArray = NDArray[np.float64]

SIGNALS = ("r", *SIMULATED[:5], "d", *SIMULATED[5:])
"""Signals of a trajectory besides the time."""


@dataclass(frozen=True, eq=False)
class Scenario:
    """One closed-loop simulation from rest.

    Attributes
    ----------
    duration : float
        Simulated time [s], rounded to whole control periods.
    reference : ReferenceProfile, float, ndarray of shape (control steps,) or callable
        Reference r [m] at each measurement.
    gap : GapProfile, float, ndarray of shape (samples + 1,) or callable
        Backlash gap theta_b [rad] at each sample and at the end of the last one.
    dead_zone : float, ndarray of shape (control steps,) or callable
        Dead-zone tolerance epsilon_dz [m] (eq. 9) at each measurement; 0 switches it off.
    model : PlantModel
        Constants of the mechanism.
    gains : PidGains
        Gains of eq. 4.
    sampling : Sampling
        Rates.
    sensor : SensorParameters
        Sensor of platform 3; the controller sees its readings.
    actuator : ActuatorParameters
        Amplifier of the motor.
    voltage_limit : float
        Largest voltage that the controller commands [V]; 0 for no limit.
    voltage_offset : float, ndarray of shape (control steps,) or callable
        Voltage [V] that the controller adds to its command at each measurement.
    notch : NotchFilter
        Filter in series with the PID.

    Notes
    -----
    Callables take the time [s] and return a float.
    """

    duration: float = 120.0
    reference: ReferenceProfile | Signal = field(default_factory=ReferenceProfile)
    gap: GapProfile | Signal = field(default_factory=GapProfile)
    dead_zone: Signal = 0.0
    model: PlantModel = field(default_factory=PlantModel)
    gains: PidGains = field(default_factory=PidGains)
    sampling: Sampling = field(default_factory=Sampling)
    sensor: SensorParameters = IDEAL_SENSOR
    actuator: ActuatorParameters = IDEAL_ACTUATOR
    voltage_limit: float = 0.0
    voltage_offset: Signal = 0.0
    notch: NotchFilter = NO_NOTCH

    def __post_init__(self) -> None:
        if self.control_steps < 1:
            raise ValueError(
                f"Scenario.duration = {self.duration!r} s: must be a control period or more"
            )

    @property
    def control_steps(self) -> int:
        """Number of measurements."""
        return round(self.duration * self.sampling.control_rate)

    @property
    def samples(self) -> int:
        """Number of samples."""
        return self.control_steps * self.sampling.samples_per_control_step


@dataclass(frozen=True, eq=False)
class Trajectory:
    """What a simulation gives: arrays of shape (samples,), empty where a signal was not kept.

    Attributes
    ----------
    t : ndarray
        Time [s]; read-only, because trajectories share it.
    r : ndarray
        Reference [m] as the controller saw it, held between measurements.
    u : ndarray
        Motor voltage [V] as commanded within the actuator's limit, from this sample to the next.
    current, omega_m, theta_m : ndarray
        Current [A], speed [rad/s] and angle [rad] of the motor.
    theta_d : ndarray
        Angle of the lead screw [rad].
    d, q1 : ndarray
        Position of the lead screw's end (eq. 1) and of platform 1, which follows a rigid one [m].
    q2, q3 : ndarray
        Positions of platforms 2 and 3 [m].
    measured : ndarray
        Position q3 as the sensor reads it [m].
    """

    t: FloatArray
    r: FloatArray
    u: FloatArray
    current: FloatArray
    omega_m: FloatArray
    theta_m: FloatArray
    theta_d: FloatArray
    d: FloatArray
    q1: FloatArray
    q2: FloatArray
    q3: FloatArray
    measured: FloatArray


def simulate(scenario: Scenario, keep: Sequence[str] = SIGNALS) -> Trajectory:
    """Simulate a scenario with the compiled kernel.

    Parameters
    ----------
    scenario : Scenario
        What to simulate.
    keep : sequence of str
        Names of the signals to keep, out of ``SIGNALS``; the time is always there. Less memory
        is less time: four signals take half the time of all.

    Returns
    -------
    Trajectory
        The signals kept.

    Raises
    ------
    ValueError
        For an unknown signal, or an array that does not have the scenario's length.
    """
    return _simulate(scenario, discrete_loop(scenario), sample_inputs(scenario), keep)


def simulate_batch(
    scenarios: Iterable[Scenario], keep: Sequence[str] = SIGNALS, workers: int | None = None
) -> list[Trajectory]:
    """Simulate many scenarios over the cores; the same floats as :func:`simulate` of each.

    The kernel works without Python's lock, so threads suffice: processes would have to copy
    every trajectory from one to the other, which takes longer than computing it.

    Parameters
    ----------
    scenarios : iterable of Scenario
        What to simulate.
    keep : sequence of str
        Names of the signals to keep.
    workers : int, optional
        Number of threads; None for as many as there are cores to run on.

    Returns
    -------
    list of Trajectory
        In the order of `scenarios`.
    """
    scenarios = list(scenarios)
    # Models first: their matrix exponentials wake the threads of BLAS, which would compete.
    steps = [discrete_loop(scenario) for scenario in scenarios]
    for is_machine in {isinstance(step.plant, DiscreteMachine) for step in steps}:
        compiled_loop(is_machine=is_machine)  # compiled once, before the threads ask for it
    inputs = [sample_inputs(scenario) for scenario in scenarios]
    with ThreadPoolExecutor(workers or os.cpu_count()) as pool:
        return list(pool.map(partial(_simulate, keep=keep), scenarios, steps, inputs))


def sample_inputs(scenario: Scenario) -> LoopInputs:
    """Return what acts on the loop at the instants at which the loop asks for it."""
    steps, samples = scenario.control_steps, scenario.samples
    rate, hold = scenario.sampling.sampling_rate, scenario.sampling.samples_per_control_step
    return LoopInputs(
        sampled("reference", scenario.reference, steps, hold, rate),
        sampled("dead_zone", scenario.dead_zone, steps, hold, rate),
        sampled("gap", scenario.gap, samples + 1, 1, rate),
        IDEAL if scenario.sensor.is_ideal else noise_sequence(scenario.sensor, 0, samples),
        sampled("voltage_offset", scenario.voltage_offset, steps, hold, rate),
    )


def discrete_loop(scenario: Scenario) -> DiscreteLoop:
    """Return the discrete models of a scenario."""
    return discretize_loop(
        scenario.model, scenario.gains, scenario.sampling, scenario.notch
    )._replace(
        command_limit=float(scenario.voltage_limit),
        amplifier=amplifier_of(scenario.actuator),
        sensor=discretize_sensor(scenario.sensor, scenario.sampling.sampling_rate),
    )


def initial_state(scenario: Scenario, inputs: LoopInputs) -> LoopState:
    """Return the state in which a scenario begins."""
    sensor = discretize_sensor(scenario.sensor, scenario.sampling.sampling_rate)
    plant = AT_REST if scenario.model.is_piecewise_linear else MACHINE_AT_REST
    return loop_at_rest(float(inputs.gaps[0]), sensor, plant)


def _simulate(
    scenario: Scenario, step: DiscreteLoop, inputs: LoopInputs, keep: Sequence[str]
) -> Trajectory:
    signals = signals_for(scenario, keep)
    run_kernel(initial_state(scenario, inputs), step, inputs, signals)
    return trajectory_of(scenario, inputs, signals, keep)


def signals_for(scenario: Scenario, keep: Sequence[str]) -> tuple[FloatArray, ...]:
    """Return the arrays for the kernel to write, for a trajectory with the signals `keep`."""
    unknown = set(keep) - set(SIGNALS)
    if unknown:
        raise ValueError(f"keep = {sorted(unknown)}: must be out of {', '.join(SIGNALS)}")
    needed = {*keep, "theta_d"} if {"d", "q1"} & set(keep) else set(keep)
    return allocate(scenario.samples, needed)


def trajectory_of(
    scenario: Scenario, inputs: LoopInputs, signals: tuple[FloatArray, ...], keep: Sequence[str]
) -> Trajectory:
    """Return the trajectory out of what acted on the loop and what the kernel wrote."""
    sampling, model = scenario.sampling, scenario.model
    kept: dict[str, FloatArray] = {
        name: signal for name, signal in zip(SIMULATED, signals, strict=True) if name in keep
    }
    if "r" in keep:
        kept["r"] = np.repeat(inputs.references, sampling.samples_per_control_step)
    if "d" in keep:
        theta_d, error = signals[SIMULATED.index("theta_d")], model.screw_mechanics.thread_error
        kept["d"] = model.lead_screw.pitch * theta_d
        if error:
            ends = (screw_end(each, model.lead_screw.pitch, error) for each in theta_d.tolist())
            kept["d"] = np.fromiter(ends, np.float64, theta_d.size)
    nothing = np.empty(0)
    return Trajectory(
        _time_axis(scenario.samples, sampling.sampling_rate),
        *(kept.get(name, nothing) for name in SIGNALS),
    )


# Trajectories of equal length share it: writing new memory takes longer than simulating.
@lru_cache(maxsize=4)
def _time_axis(samples: int, rate: float) -> FloatArray:
    times = np.arange(samples) / rate
    times.flags.writeable = False
    return times
