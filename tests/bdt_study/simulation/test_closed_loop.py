"""The compiled loop against the plain Python loop of the same cores, bit for bit."""

import dataclasses
import itertools
from pathlib import Path

import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bdt_controller.control_law import BLEND_TIME
from bdt_controller.controller import ControllerSettings, DeadZoneController
from bdt_controller.notch import NotchFilter
from bdt_controller.pid import PidGains
from bdt_controller.reference import ReferenceProfile, reference_at
from bdt_plant.actuator import ActuatorParameters
from bdt_plant.amplifier_lag import AmplifierLag
from bdt_plant.cogging import CoggingParameters
from bdt_plant.compilation import compile_loop, source_files, source_hash
from bdt_plant.gap_profile import GapProfile, gap_at
from bdt_plant.motor import MotorParameters
from bdt_plant.plant import PlantModel, Sampling
from bdt_plant.plant_simulator import PlantSimulator
from bdt_plant.pushes import PushParameters
from bdt_plant.screw_load import ScrewMechanics
from bdt_plant.sensor import SensorParameters
from bdt_plant.stiffening_tower import BeamParameters
from bdt_plant.stribeck import StribeckParameters
from bdt_study.simulation import loop_kernel
from bdt_study.simulation.closed_loop import (
    SIGNALS,
    Scenario,
    discrete_loop,
    initial_state,
    sample_inputs,
    simulate,
    simulate_batch,
)
from bdt_study.simulation.loop_kernel import SIMULATED, allocate, run_kernel
from bdt_study.simulation.loop_model import LoopInputs, loop_at_rest

REFERENCE = ReferenceProfile(step_time=2.0)
GROWING = GapProfile(growth_time=8.0)

COLUMNS = (
    *("t", "r", "u", "current", "omega_m", "theta_m", "theta_d"),
    *("q1", "q2", "q3", "measured"),
)
"""Signals in the order of :func:`python_loop`."""

LABORATORY = Scenario(
    4.0,
    REFERENCE,
    GROWING,
    2.8e-5,
    PlantModel(MotorParameters(coulomb_friction=0.02, viscous_friction=1e-4)),
    sensor=SensorParameters(1e-6, 1e-7, 1.03e-3, 0.1, 3, 1e-6, 1e-7, 5e-7, 2e-5),
    actuator=ActuatorParameters(True, 8.0, 0.01, 0.99, 1e-3),
    voltage_limit=9.0,
    voltage_offset=0.03,
)
"""Every imperfection of sensor and amplifier, and a controller that believes in a stronger one."""

MACHINE = dataclasses.replace(
    LABORATORY,
    duration=0.5,
    model=PlantModel(
        MotorParameters(coulomb_friction=0.008),
        stribeck=StribeckParameters(0.01, 2.0, 0.1),
        cogging=CoggingParameters(1e-3),
        screw_mechanics=ScrewMechanics(0.4, 1e7, 1e-6),
        beams=BeamParameters(2e6),
        pushes=PushParameters(2.0, 0.05, 0.3, seed=5),
        amplifier=AmplifierLag(1e-3),
    ),
)
"""Whatever the paper leaves out of the mechanism, with all that."""


def test_the_end_of_a_rigid_screw_is_platform_1_also_where_its_thread_is_off():
    model = PlantModel(screw_mechanics=ScrewMechanics(thread_error=2e-6))
    loop = simulate(dataclasses.replace(LABORATORY, model=model), ("d", "q1", "theta_d"))
    assert loop.d == pytest.approx(loop.q1, abs=1e-15)
    off = loop.d - model.lead_screw.pitch * loop.theta_d
    assert off == pytest.approx(2e-6 * np.sin(loop.theta_d), abs=1e-15)
    assert np.abs(off).max() > 1e-6


def python_loop(scenario, dead_zones):
    """Return rows (t, r, u, i, w_m, theta_m, theta_d, q1, q2, q3, reading).

    The state is that of the last measurement.
    """
    plant = PlantSimulator(
        scenario.model, scenario.gap, scenario.sampling, scenario.sensor, scenario.actuator
    )
    rate, limit = scenario.sampling.control_rate, scenario.voltage_limit
    settings = ControllerSettings(control_rate=rate)
    controller = DeadZoneController(scenario.gains, settings, scenario.notch)
    rows = []
    for tolerance in dead_zones:
        settings = ControllerSettings(rate, float(tolerance), limit, scenario.voltage_offset)
        controller.configure(scenario.gains, settings, scenario.notch)
        r = reference_at(scenario.reference, plant.time)
        t, theta_m, theta_d, _, *q = plant.truth()
        motor = plant.state.motor
        for time, u, reading in plant.advance(controller.step(r, plant.position)):
            row = (r, u, motor.current, motor.speed, theta_m, theta_d, *q, reading)
            rows.append((time, *row))
        assert rows[-scenario.sampling.samples_per_control_step][0] == t
    return np.array(rows)


def assert_same_bits(actual, expected):
    assert np.ascontiguousarray(actual).tobytes() == np.ascontiguousarray(expected).tobytes()


def assert_is_the_python_loop(scenario, dead_zone):
    trajectory = simulate(scenario)
    expected = python_loop(scenario, [dead_zone] * scenario.control_steps)
    # Between two measurements the Python loop does not show the state.
    each_sample = scenario.sampling.samples_per_control_step == 1
    for name in COLUMNS if each_sample else ("t", "r", "u", "measured"):
        assert_same_bits(getattr(trajectory, name), expected[:, COLUMNS.index(name)])
    return trajectory


@pytest.mark.parametrize("gap", [GROWING, GapProfile("constant"), GapProfile("constant", 0.3)])
@pytest.mark.parametrize("dead_zone", [0.0, 2.8e-5])
def test_every_signal_is_that_of_the_python_loop_bit_for_bit(gap, dead_zone):
    # With a measurement at every sample the Python loop shows its whole state at every sample.
    sampling = Sampling(control_rate=5000.0)
    scenario = Scenario(3.0, REFERENCE, gap, dead_zone, sampling=sampling)
    trajectory = assert_is_the_python_loop(scenario, dead_zone)
    assert_same_bits(trajectory.d, trajectory.q1)


def test_a_filter_in_series_is_that_of_the_python_loop_bit_for_bit():
    scenario = Scenario(
        3.0,
        REFERENCE,
        GROWING,
        notch=NotchFilter(27.0, 0.1, 0.6),
        sampling=Sampling(5000.0, 5000.0),
    )
    dead_zones = np.where(np.arange(scenario.control_steps) < 9000, 0.0, 2.8e-5)
    trajectory = simulate(dataclasses.replace(scenario, dead_zone=dead_zones))
    expected = python_loop(scenario, dead_zones)
    for name, column in zip(COLUMNS, expected.T, strict=True):
        assert_same_bits(getattr(trajectory, name), column)


@pytest.mark.parametrize("control_rate", [5000.0, 500.0])
def test_an_imperfect_loop_is_that_of_the_python_loop_bit_for_bit(control_rate):
    scenario = dataclasses.replace(LABORATORY, sampling=Sampling(control_rate=control_rate))
    trajectory = assert_is_the_python_loop(scenario, 2.8e-5)
    assert np.abs(trajectory.u).max() == 8.0
    assert np.abs(trajectory.measured - trajectory.q3).max() > 3e-6


@pytest.mark.parametrize("control_rate", [5000.0, 500.0])
def test_a_mechanism_that_is_not_linear_is_that_of_the_python_loop_bit_for_bit(control_rate):
    sampling = Sampling(control_rate=control_rate, sub_steps=2)
    trajectory = assert_is_the_python_loop(dataclasses.replace(MACHINE, sampling=sampling), 2.8e-5)
    assert np.abs(trajectory.q1 - trajectory.d).max() > 1e-6  # its screw is elastic


def assert_stops_change_nothing(scenario, stops):
    inputs, step = sample_inputs(scenario), discrete_loop(scenario)
    state, parts = initial_state(scenario, inputs), []
    for first, last in itertools.pairwise([0, *sorted(stops), scenario.control_steps]):
        parts.append(allocate(10 * (last - first)))
        state = run_kernel(state, step, inputs.between(first, last), parts[-1])
    whole = simulate(scenario)
    for index, name in enumerate(SIMULATED):
        assert_same_bits(np.concatenate([part[index] for part in parts]), getattr(whole, name))


def test_a_mechanism_that_is_not_linear_stops_and_goes_on_as_one():
    assert_stops_change_nothing(MACHINE, [7, 200])


def test_the_voltage_offset_may_change_at_any_measurement_and_does_so_without_a_bump():
    offsets = np.where(np.arange(1000) < 250, 0.0, -0.02)
    scenario = Scenario(2.0, 0.0, 0.1, 1e-3)
    trajectory = simulate(dataclasses.replace(scenario, voltage_offset=offsets), ("u",))
    since = np.maximum(np.arange(1000) - 250, 0) / 500.0
    expected = offsets * (1.0 - np.exp(-since / BLEND_TIME))
    assert trajectory.u == pytest.approx(np.repeat(expected, 10), abs=2e-9)
    assert trajectory.u[-1] == -0.02
    assert_same_bits(
        simulate(dataclasses.replace(scenario, voltage_offset=0)).q3, simulate(scenario).q3
    )


def test_the_ideal_sensor_measures_the_position():
    trajectory = simulate(Scenario(1.0, REFERENCE, GROWING))
    assert_same_bits(trajectory.measured, trajectory.q3)


@settings(max_examples=25)
@given(st.data())
def test_an_imperfect_loop_that_stops_and_goes_on_is_one_loop(data):
    steps = st.integers(1, LABORATORY.control_steps - 1)
    assert_stops_change_nothing(LABORATORY, data.draw(st.lists(steps, max_size=5, unique=True)))


def test_running_from_a_state_leaves_it_as_it_was():
    inputs, step = sample_inputs(LABORATORY), discrete_loop(LABORATORY)
    state, signals = initial_state(LABORATORY, inputs), allocate(LABORATORY.samples)
    run_kernel(state, step, inputs, signals)
    first = signals[-1].copy()
    run_kernel(state, step, inputs, signals)
    assert_same_bits(signals[-1], first)


def test_a_dead_zone_that_changes_is_a_reconfigured_controller():
    steps = 3000
    dead_zones = np.where(np.arange(steps) < 1000, 0.0, np.linspace(0, 8e-5, steps))
    scenario = Scenario(6.0, REFERENCE, GROWING, dead_zones)
    trajectory = simulate(scenario)
    expected = python_loop(scenario, dead_zones)
    for name, column in (("t", 0), ("r", 1), ("u", 2), ("q3", 10)):
        assert_same_bits(getattr(trajectory, name), expected[:, column])


@settings(max_examples=25)
@given(
    gains=st.builds(
        PidGains,
        st.floats(-1e5, 1e5),
        st.floats(-1e6, 1e6),
        st.floats(-1e3, 1e3),
        st.floats(1e-3, 1.0),
    ),
    gap=st.floats(0.0, 1.0),
    level=st.floats(-1e-2, 1e-2),
    dead_zone=st.floats(0.0, 1e-3),
)
def test_any_gains_gap_and_dead_zone_give_the_same_bits(gains, gap, level, dead_zone):
    reference = ReferenceProfile("table", table_positions=(level,))
    scenario = Scenario(0.1, reference, GapProfile("constant", gap), dead_zone, gains=gains)
    expected = python_loop(scenario, [dead_zone] * 50)
    trajectory = simulate(scenario)
    assert_same_bits(trajectory.u, expected[:, 2])
    assert_same_bits(trajectory.q3, expected[:, 10])


def test_laws_arrays_and_callables_are_the_same_scenario():
    base = Scenario(1.0, REFERENCE, GROWING, 1e-5)
    times = np.arange(5001) / 5000.0
    arrays = dataclasses.replace(
        base,
        reference=np.array([reference_at(REFERENCE, t) for t in times[:-1:10].tolist()]),
        gap=np.array([gap_at(GROWING, t) for t in times.tolist()]),
        dead_zone=np.full(500, 1e-5),
    )
    callables = dataclasses.replace(
        base,
        reference=lambda t: reference_at(REFERENCE, t),
        gap=lambda t: gap_at(GROWING, t),
        dead_zone=lambda _: 1e-5,
    )
    for other in (arrays, callables):
        for name in SIGNALS:
            assert_same_bits(
                getattr(simulate(other), name),
                getattr(simulate(base), name),
            )


def test_only_what_is_asked_for_is_kept():
    scenario = Scenario(0.5, REFERENCE, GROWING)
    whole = simulate(scenario)
    for keep in ((), ("q3",), ("d",), ("u", "theta_m", "theta_d", "q3"), ("r", "q1")):
        part = simulate(scenario, keep)
        for name in SIGNALS:
            expected = getattr(whole, name) if name in keep else np.empty(0)
            assert_same_bits(getattr(part, name), expected)


def test_a_batch_is_its_scenarios_one_by_one():
    scenarios = [
        Scenario(0.5, REFERENCE, GapProfile("constant", gap), 1e-5) for gap in (0.0, 0.1, 0.5)
    ]
    scenarios.append(dataclasses.replace(MACHINE, duration=0.5))
    batch = simulate_batch(scenarios, ("u", "q3"), workers=2)
    assert len(batch) == 4
    for scenario, trajectory in zip(scenarios, batch, strict=True):
        assert_same_bits(trajectory.q3, simulate(scenario).q3)


def test_a_loop_that_stops_and_goes_on_is_one_loop():
    scenario = Scenario(1.0, REFERENCE, GROWING, 1e-5)
    inputs, step = sample_inputs(scenario), discrete_loop(scenario)
    state, parts = loop_at_rest(0.0), []
    for first, last in ((0, 7), (7, 300), (300, 500)):
        stretch = LoopInputs(
            inputs.references[first:last],
            inputs.tolerances[first:last],
            inputs.gaps[10 * first : 10 * last + 1],
        )
        parts.append(allocate(10 * (last - first)))
        state = run_kernel(state, step, stretch, parts[-1])
    whole = simulate(scenario)
    for index, name in enumerate(SIMULATED):
        assert_same_bits(np.concatenate([part[index] for part in parts]), getattr(whole, name))


def test_whole_numbers_are_floats():
    whole = Scenario(1, 1, 0, 0, gains=PidGains(3000, 30000, -300, 1))
    floats = Scenario(1.0, 1.0, 0.0, 0.0, gains=PidGains(3000.0, 30000.0, -300.0, 1.0))
    assert_same_bits(simulate(whole).q3, simulate(floats).q3)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"reference": np.zeros(499)}, "reference"),
        ({"gap": np.zeros(5000)}, "gap"),
        ({"dead_zone": np.zeros((500, 1))}, "dead_zone"),
        ({"voltage_offset": np.zeros(499)}, "voltage_offset"),
    ],
)
def test_an_array_of_another_length_is_refused(arguments, name):
    with pytest.raises(ValueError, match=f"{name} = array of shape"):
        simulate(Scenario(1.0, **arguments))


def test_unknown_signals_and_no_time_are_refused():
    with pytest.raises(ValueError, match="keep = \\['q4'\\]"):
        simulate(Scenario(1.0), ("q3", "q4"))
    with pytest.raises(ValueError, match="duration"):
        Scenario(0.0)


def test_the_kernel_is_compiled_anew_when_an_equation_changes(tmp_path, monkeypatch):
    names = {Path(name).name for name in source_files(loop_kernel.COMPILED)}
    cores = ("plant", "motor", "lead_screw", "structure", "pid", "dead_zone")
    assert names >= {f"{core}.py" for core in (*cores, "friction", "sensor", "actuator")}
    core = tmp_path / "core.py"
    core.write_text("y = x")
    before = source_hash([str(core)])
    core.write_text("y = -x")
    after = source_hash([str(core)])
    assert before != after

    # Numba's own cache knows the file of the kernel, not those of the equations.
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    for sources, hits in ((before, 0), (before, 1), (after, 0)):
        compiled = compile_loop(loop_kernel._closed_loop(sources), loop_kernel._signature())
        assert sum(compiled.stats.cache_hits.values()) == hits
