"""Benchmarks of the cores: medians of one run on one machine, beside what to beat."""

import os
import platform
import time
from collections.abc import Callable, Iterable
from dataclasses import asdict, replace
from functools import partial
from importlib.metadata import entry_points, version
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from scipy.signal import lfilter

from bdt_controller.controller import ControllerSettings, DeadZoneController
from bdt_controller.pid import PidGains
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.commands import BENCHMARK_GROUP
from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import PlantModel, Sampling
from bdt_study.benchmarks.c_loop import FLAGS, KEPT, NoCompilerError, build_c_loop, c_loop_call
from bdt_study.benchmarks.program import bdt_help, lockstep_real_time_factor
from bdt_study.benchmarks.python_control_loop import interconnected_loop, step_response
from bdt_study.benchmarks.real_time import real_time
from bdt_study.benchmarks.result import BenchmarkResult, BenchmarkSize, compared
from bdt_study.benchmarks.sweep import sweep, sweep_kills
from bdt_study.benchmarks.transport import (
    discovery,
    one_way_6kb,
    one_way_joint_state,
    pingpong_vs_raw,
    start_up,
)
from bdt_study.benchmarks.twins import twins
from bdt_study.simulation.closed_loop import (
    Scenario,
    discrete_loop,
    sample_inputs,
    simulate,
    simulate_batch,
)
from bdt_study.simulation.loop_kernel import SIMULATED, allocate, run_kernel
from bdt_study.simulation.loop_model import loop_at_rest
from bdt_twin.angle_observer import motor_filter, structure_filter
from bdt_twin.inverse_filter import InverseFilterEstimator, InverseFilterSettings

MEAN_GAP = float(np.deg2rad(10.0))
"""Constant gap [rad] of the comparison with python-control, the mean of the paper's."""

FINE_RATE = 1e6
"""Sampling rate [Hz] of the solutions that errors are measured against."""


def run_benchmarks(names: Iterable[str] = (), size: BenchmarkSize | None = None) -> dict[str, Any]:
    """Run benchmarks and return what ``bdt bench --json`` prints.

    Parameters
    ----------
    names : iterable of str
        Names out of ``BENCHMARKS``, none for all of these, or of benchmarks of other packages.
    size : BenchmarkSize, optional
        How much to compute; None for the size that the README's numbers are of.

    Returns
    -------
    dict
        ``{"machine": {...}, "results": [...]}``, each result with the fields of a
        :class:`BenchmarkResult`.

    Raises
    ------
    BadInputError
        For an unknown name.
    """
    wanted = list(names) or list(BENCHMARKS)
    others = {point.name: point for point in entry_points(group=BENCHMARK_GROUP)}
    for name in wanted:
        if name not in BENCHMARKS and name not in others:
            known = ", ".join((*BENCHMARKS, *others))
            raise BadInputError(f"benchmark {name!r}: must be one of {known}")
    size = size or BenchmarkSize()
    results: list[dict[str, Any]] = []
    for name in wanted:
        if name in BENCHMARKS:
            results += [asdict(result) for result in BENCHMARKS[name](size)]
        else:
            told = others[name].load()(size.real_time_duration)
            results += [asdict(BenchmarkResult(**result)) for result in told]
    return {"machine": machine(), "results": results}


def machine() -> dict[str, Any]:
    """Return what the numbers depend on: processor, cores, versions."""
    models = [
        line.partition(":")[2].strip()
        for line in _lines(Path("/proc/cpuinfo"))
        if line.startswith("model name")
    ]
    packages = ("numpy", "scipy", "numba", "control")
    return {
        "processor": models[0] if models else platform.processor(),
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "python": platform.python_version(),
        **{name: version(name) for name in packages},
    }


def kernel_vs_c(size: BenchmarkSize) -> list[BenchmarkResult]:
    """Time the kernel over the paper's scenario against the same loop in C, four signals kept."""
    scenario = Scenario(size.duration)
    state, step, inputs = loop_at_rest(0.0), discrete_loop(scenario), sample_inputs(scenario)
    signals = allocate(scenario.samples, KEPT)
    kernel = partial(run_kernel, state, step, inputs, signals)
    name, unit = "kernel_vs_c", "ms"
    try:
        library = build_c_loop()
    except NoCompilerError as error:
        (ours,) = _medians(size.repeats, kernel)
        return [BenchmarkResult(name, 1e3 * ours, unit, f"C skipped: {error}")]
    written = tuple(np.empty(scenario.samples) for _ in KEPT)
    c_loop = c_loop_call(library, state, step, inputs, written)
    ours, theirs = _medians(size.repeats, kernel, c_loop)
    position, reference = signals[SIMULATED.index("q3")], written[KEPT.index("q3")]
    difference = float(np.abs(position - reference).max())
    what = f"C, {' '.join(FLAGS[:3])}; q3 differs by {difference:.1e} m at most"
    return [compared(name, 1e3 * ours, unit, what, 1e3 * theirs)]


def kernel_vs_python_control(size: BenchmarkSize) -> list[BenchmarkResult]:
    """Compare speed and error with input_output_response, with the faster of two methods.

    The loop of python-control has no sampling. The error of each is measured against a fine
    solution of its own loop, with and without a controller at 500 Hz.
    """
    scenario = Scenario(size.duration, gap=GapProfile("constant", MEAN_GAP))
    step, inputs = discrete_loop(scenario), sample_inputs(scenario)
    signals = allocate(scenario.samples, KEPT)
    kernel = partial(run_kernel, loop_at_rest(MEAN_GAP), step, inputs, signals)
    (ours,) = _medians(size.repeats, kernel)

    short = replace(scenario, duration=size.python_control_duration)
    rate = scenario.sampling.sampling_rate
    times = np.arange(short.samples) / rate
    loop = interconnected_loop(scenario.model, scenario.gains, MEAN_GAP)
    level = float(inputs.references[0])
    continuous = _position(short, FINE_RATE, FINE_RATE)
    sampled = _position(short, FINE_RATE, scenario.sampling.control_rate)
    our_error = float(np.abs(simulate(short, ("q3",)).q3 - sampled).max())

    results = []
    for method in ("LSODA", "RK45"):
        start = time.perf_counter()
        position = step_response(loop, level, times, method)
        theirs = time.perf_counter() - start
        error = float(np.abs(position - continuous).max())
        speeds = (size.duration / ours, size.python_control_duration / theirs)
        what = f"python-control, {method}, {size.python_control_duration:g} s"
        results += [
            compared("kernel_vs_python_control", speeds[0], "simulated s/s", what, speeds[1]),
            compared("kernel_vs_python_control", our_error, "m error of q3", what, error),
        ]
    return results


def batch_scaling(size: BenchmarkSize) -> list[BenchmarkResult]:
    """Time a batch on one core and on all: the speed-up beside the number of cores."""
    cores = os.cpu_count() or 1
    gains = [PidGains(integral=30000.0 + k) for k in range(size.batch * cores)]
    scenarios = [Scenario(size.duration, gains=each) for each in gains]
    runs = [partial(simulate_batch, scenarios, ("q3",), workers=workers) for workers in (1, cores)]
    one, many = _medians(max(size.repeats // 4, 1), *runs)
    return [compared("batch_scaling", one / many, "times", "cores", float(cores))]


def estimator_vs_lfilter(size: BenchmarkSize) -> list[BenchmarkResult]:
    """Time the paper's estimator against the two ``lfilter`` passes of eqs 10 and 11."""
    trajectory = simulate(Scenario(size.duration), ("u", "q3"))
    voltage, position = trajectory.u, trajectory.q3
    estimator = InverseFilterEstimator(PlantModel(), InverseFilterSettings())
    sample_time = 1.0 / Sampling().sampling_rate
    motor = motor_filter(PlantModel(), sample_time)
    numerator, inverse = structure_filter(PlantModel(), sample_time)

    def estimate() -> None:
        estimator.restart()
        estimator.estimates(voltage, position)

    def bare() -> None:
        lfilter(*motor, voltage)
        lfilter(inverse, numerator[1:], position)

    ours, theirs = _medians(size.repeats, estimate, bare)
    what = "two lfilter passes"
    return [compared("estimator_vs_lfilter", 1e3 * ours, "ms", what, 1e3 * theirs)]


def control_step(size: BenchmarkSize) -> list[BenchmarkResult]:
    """Time one control step as the controller node calls it, beside the control period."""
    settings = ControllerSettings(dead_zone_tolerance=1e-5)
    controller = DeadZoneController(PidGains(), settings)
    steps = 1000

    def control() -> None:
        for _ in range(steps):
            controller.step(5e-3, 4.9e-3)

    (taken,) = _medians(size.repeats, control)
    period = 1e6 / settings.control_rate
    return [compared("control_step", 1e6 * taken / steps, "us", "control period", period)]


BENCHMARKS: dict[str, Callable[[BenchmarkSize], list[BenchmarkResult]]] = {
    function.__name__: function
    for function in (
        kernel_vs_c,
        kernel_vs_python_control,
        batch_scaling,
        estimator_vs_lfilter,
        control_step,
        pingpong_vs_raw,
        lockstep_real_time_factor,
        real_time,
        one_way_joint_state,
        one_way_6kb,
        discovery,
        start_up,
        bdt_help,
        sweep,
        sweep_kills,
        twins,
    )
}
"""Benchmarks by name, in the order in which they run."""


def _position(
    scenario: Scenario, sampling_rate: float, control_rate: float
) -> np.ndarray[Any, Any]:
    """Return q3 [m] of a finer simulation at the samples of `scenario`."""
    fine = replace(scenario, sampling=Sampling(sampling_rate, control_rate))
    ratio = round(sampling_rate / scenario.sampling.sampling_rate)
    return simulate(fine, ("q3",)).q3[::ratio]


def _medians(repeats: int, *functions: Callable[[], Any]) -> list[float]:
    """Return the median time of each function [s]; they take turns, so a busy time hits all."""
    for function in functions:
        function()
    times: list[list[float]] = [[] for _ in functions]
    for _ in range(repeats):
        for function, taken in zip(functions, times, strict=True):
            start = time.perf_counter()
            function()
            taken.append(time.perf_counter() - start)
    return [median(taken) for taken in times]


def _lines(path: Path) -> list[str]:
    return path.read_text().splitlines() if path.is_file() else []
