"""The compiled loop with the twin against the plain Python loop, which the nodes equal."""

import dataclasses
import math

import numpy as np
import pytest

from bdt_controller.controller import ControllerSettings, DeadZoneController
from bdt_controller.notch import NO_NOTCH
from bdt_controller.pid import PidGains
from bdt_controller.reference import ReferenceProfile, reference_at
from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import PlantModel, Sampling
from bdt_plant.plant_simulator import PlantSimulator
from bdt_plant.sensor import IDEAL_SENSOR, SensorParameters
from bdt_study.evaluation.trial import MARGIN
from bdt_study.simulation.closed_loop import Scenario, simulate
from bdt_study.simulation.twin_loop import simulate_with_twin
from bdt_twin.dead_zone_tolerance import DeadZoneSettings, tolerance_for_gap
from bdt_twin.decider import create_decider
from bdt_twin.decision import ControllerGains
from bdt_twin.decision_settings import DecisionSettings
from bdt_twin.estimator import Estimate
from bdt_twin.inverse_filter import InverseFilterEstimator, InverseFilterSettings
from bdt_twin.link import LinkSettings
from bdt_twin.output_error import OutputErrorEstimator
from bdt_twin.output_error_settings import OutputErrorSettings

SCENARIO = Scenario(6.0, ReferenceProfile(step_time=2.0), GapProfile(growth_time=8.0))

PITCH = PlantModel().lead_screw.pitch

NOISY = SensorParameters(noise=1e-14, quantization=1e-15, delay=4e-4)
"""A sensor whose readings this estimator stands."""


def python_loop(delay, sensor=IDEAL_SENSOR):
    """Return telemetry as ``offline_loop`` of tests/test_loop.py computes it."""
    plant = PlantSimulator(PlantModel(), SCENARIO.gap, Sampling(), sensor)
    controller = DeadZoneController(PidGains(), ControllerSettings())
    estimator = InverseFilterEstimator(PlantModel(), InverseFilterSettings())
    rows, on_the_way = [], []
    for step in range(SCENARIO.control_steps):
        while on_the_way and on_the_way[0][0] <= plant.nanoseconds:
            settings = ControllerSettings(dead_zone_tolerance=on_the_way.pop(0)[1])
            controller.configure(PidGains(), settings)
        r = reference_at(SCENARIO.reference, plant.time)
        rows.append(plant.advance(controller.step(r, plant.position)))
        if (step + 1) % 50 == 0:
            batch = np.concatenate(rows[-50:])
            estimates = estimator.estimates(batch[:, 1], batch[:, 2])
            if estimates:
                tolerance = tolerance_for_gap(estimates[-1].gap, PlantModel().lead_screw.pitch)
                on_the_way.append((round((batch[-1, 0] + delay) * 1e9), tolerance))
    return np.concatenate(rows)


def link(delay):
    return LinkSettings(communication_delay=delay)


@pytest.mark.parametrize("delay", [0.0, 0.33, 0.3301, 1.0])
def test_the_loop_is_that_of_the_nodes_bit_for_bit(delay):
    result = simulate_with_twin(SCENARIO, link=link(delay))
    actual = np.column_stack([result.loop.t, result.loop.u, result.loop.q3])
    assert actual.tobytes() == python_loop(delay).tobytes()
    assert result.estimated_gaps.shape == result.estimate_times.shape
    assert np.count_nonzero(np.diff(result.tolerances)) > 5


def test_controller_and_twin_get_the_sensor_s_readings():
    result = simulate_with_twin(dataclasses.replace(SCENARIO, sensor=NOISY), link=link(0.33))
    actual = np.column_stack([result.loop.t, result.loop.u, result.loop.measured])
    assert actual.tobytes() == python_loop(0.33, NOISY).tobytes()
    assert np.count_nonzero(np.diff(result.tolerances)) > 5


def test_the_dead_zones_reported_are_those_that_acted():
    result = simulate_with_twin(SCENARIO, link=link(0.33))
    again = simulate(Scenario(6.0, SCENARIO.reference, SCENARIO.gap, result.tolerances))
    for name in ("u", "theta_d", "q1", "q3"):
        assert getattr(again, name).tobytes() == getattr(result.loop, name).tobytes()


def test_a_reconfiguration_arrives_after_its_delay():
    result = simulate_with_twin(SCENARIO, link=link(0.33), keep=())
    first = np.flatnonzero(result.tolerances)[0] / 500.0
    sent = result.estimate_times[np.flatnonzero(result.estimated_gaps > 0)[0]]
    # It is sent at the end of the batch in which its update period ended.
    assert first == pytest.approx(np.ceil(sent / 0.1) * 0.1 + 0.33, abs=0.002)
    assert result.loop.q2.size == 0


def test_the_delay_may_differ_from_message_to_message():
    fixed = simulate_with_twin(SCENARIO, link=link(0.33))
    table = LinkSettings(delay_distribution="table", delay_table=(0.33,))
    drawn = simulate_with_twin(SCENARIO, link=table)
    assert fixed.loop.q3.tobytes() == drawn.loop.q3.tobytes()
    uniform = LinkSettings(communication_delay=0.25, delay_distribution="uniform", delay_spread=1.0)
    random = simulate_with_twin(SCENARIO, link=uniform)
    assert random.tolerances.tobytes() != fixed.tolerances.tobytes()
    pitch = PlantModel().lead_screw.pitch
    assert set(random.tolerances) <= {
        0.0,
        *(tolerance_for_gap(gap, pitch) for gap in random.estimated_gaps),
    }


def test_what_is_lost_on_the_link_changes_nothing():
    none = simulate_with_twin(SCENARIO, link=LinkSettings(request_loss=1.0))
    assert not none.tolerances.any()
    some = simulate_with_twin(SCENARIO, link=LinkSettings(request_loss=0.5))
    every = simulate_with_twin(SCENARIO)
    changes = [np.count_nonzero(np.diff(run.tolerances)) for run in (some, every)]
    assert 0 < changes[0] < changes[1]


class Certain:
    """An estimator that is sure of a gap that grows by 0.01 rad/s."""

    def restart(self):
        pass

    def update(self, batch, *, newest_only=False):
        return Estimate(float(batch[-1, 0]), 0.2, uncertainty=0.01, growth=0.01)


def test_any_estimator_will_do_and_the_dead_zone_is_a_bound_when_it_takes_effect():
    settings = DeadZoneSettings(coverage_factor=2.0)
    run = simulate_with_twin(SCENARIO, Certain(), link(0.33), settings)
    bound = 0.2 + 2.0 * 0.01 + 0.01 * 0.33
    assert run.tolerances[-1] == pytest.approx(bound * PlantModel().lead_screw.pitch, rel=1e-12)


class KnowsTheAmplifier(Certain):
    """An estimator that finds that the amplifier adds 20 mV, from 2 s on."""

    def update(self, batch, *, newest_only=False):
        time = float(batch[-1, 0])
        estimate = Estimate(time, 0.2 + 0.01 * time)
        found = {"voltage_offset": 0.02, "voltage_offset_uncertainty": 1e-3}
        return estimate._replace(**found) if time > 2.0 else estimate


def test_the_amplifier_s_offset_is_compensated_with_the_dead_zone_from_its_arrival_on():
    run = simulate_with_twin(SCENARIO, KnowsTheAmplifier(), link(0.33))
    first = int(np.flatnonzero(run.voltage_offsets)[0])
    assert first / 500.0 == pytest.approx(2.1 + 0.33, abs=0.002)
    assert set(run.voltage_offsets[first:]) == {-0.02}
    assert run.tolerances[first] != run.tolerances[first - 1]
    again = simulate(
        dataclasses.replace(SCENARIO, dead_zone=run.tolerances, voltage_offset=run.voltage_offsets)
    )
    assert again.u.tobytes() == run.loop.u.tobytes()
    assert np.any(run.loop.u == -0.02), "the command in the dead zone"


def test_without_compensation_or_knowledge_the_offset_of_the_scenario_stays():
    scenario = dataclasses.replace(SCENARIO, voltage_offset=0.01)
    known = simulate_with_twin(scenario, KnowsTheAmplifier(), compensate_offset=False)
    assert set(known.voltage_offsets) == {0.01}
    unknown = simulate_with_twin(scenario, Certain())
    assert set(unknown.voltage_offsets) == {0.01}


def test_a_motor_that_creeps_in_the_dead_zone_rests_once_the_offset_is_compensated():
    """An amplifier that adds 50 mV, which a plant that is told of the sum stands for."""

    def travel_at_rest(voltage_offset):
        plant = PlantSimulator(PlantModel(), GapProfile("constant", 0.2), Sampling())
        settings = ControllerSettings(
            dead_zone_tolerance=2.0 * PITCH * 0.2, voltage_offset=voltage_offset
        )
        controller = DeadZoneController(PidGains(), settings)
        angles = []
        for _ in range(5000):
            plant.advance(controller.step(1e-3, plant.position) + 0.05)
            angles.append(plant.truth()[1])
        return np.ptp(angles[-1000:])

    assert travel_at_rest(-0.05) < 1e-6
    assert travel_at_rest(0.0) > 0.1


def test_a_loop_that_has_rested_for_long_follows_the_next_step_and_learns_again():
    """Laboratory.yaml's dead zone; doubt that grows 250 times as fast stands for a long rest."""
    changes = [*range(0, 16, 4), 60, 64, 68]

    def reference(time):
        return 0.0 if np.searchsorted(changes, time, side="right") % 2 else 2e-3

    scenario = Scenario(
        72.0,
        reference,
        GapProfile(kind="constant", initial=np.deg2rad(10.0)),
        sampling=Sampling(sampling_rate=1000.0),
        sensor=SensorParameters(noise=1e-6, quantization=1e-7),
    )
    estimator = OutputErrorEstimator(
        PlantModel(),
        OutputErrorSettings(growth_change=np.deg2rad(5.0), window=8.0, update_period=2.0),
        1000.0,
    )
    result = simulate_with_twin(scenario, estimator, dead_zone=MARGIN, keep=("q3",))
    at_rest = [one for one in result.estimates if 50.0 < one.time + one.age < 60.0]
    assert all(one.reason for one in at_rest)
    assert tolerance_for_gap(2.0 * at_rest[-1].uncertainty, PITCH) > 2e-3
    assert not result.estimates[-1].reason
    assert math.degrees(result.estimates[-1].gap) == pytest.approx(10.0, abs=1.0)
    for end in (64, 68, 72):
        tail = slice((end - 1) * 1000, end * 1000)
        bias = np.mean(result.loop.q3[tail]) - reference(end - 0.5)
        assert abs(bias) < 0.05 * 2e-3


def python_loop_with_decisions(scenario, decision, redesign, delay):
    """Return voltages and readings as the nodes compute them, decisions included."""
    plant = PlantSimulator(scenario.model, scenario.gap, Sampling(), scenario.sensor)
    controller = DeadZoneController(PidGains(), ControllerSettings())
    estimator = InverseFilterEstimator(PlantModel(), InverseFilterSettings())
    today = ControllerGains(PidGains(), NO_NOTCH)
    decide = create_decider(decision, PlantModel(), today, redesign, estimator, delay, 0.0)
    rows, on_the_way, decisions = [], [], []
    for step in range(scenario.control_steps):
        while on_the_way and on_the_way[0][0] <= plant.nanoseconds:
            _, tolerance, pid, notch = on_the_way.pop(0)
            controller.configure(pid, ControllerSettings(dead_zone_tolerance=tolerance), notch)
        r = reference_at(scenario.reference, plant.time)
        rows.append(plant.advance(controller.step(r, plant.position)))
        if (step + 1) % 50 == 0:
            batch = np.concatenate(rows[-50:])
            estimate = estimator.update(batch)
            found = decide(batch, estimate, begins=False)
            if found is not None:
                decisions.append(found)
                due = round((batch[-1, 0] + delay) * 1e9)
                tolerance = found.tolerance
                if tolerance is None:
                    tolerance = tolerance_for_gap(estimate.gap, PITCH)
                on_the_way.append((due, tolerance, *found.gains))
    return np.concatenate(rows), decisions


@pytest.mark.parametrize("delay", [0.33, 0.4])
def test_decisions_change_dead_zone_and_gains_as_in_the_nodes_bit_for_bit(delay):
    redesign = ControllerGains(PidGains(6284.7, 12569.0, -868.39, 0.11636), NO_NOTCH)
    settings = DecisionSettings(
        kind="simulate", reconfigure_gains=True, members=2, step_heights=(5e-3,)
    )
    scenario = dataclasses.replace(SCENARIO, sensor=NOISY)
    run = simulate_with_twin(scenario, link=link(delay), decision=settings, redesign=redesign)
    rows, decisions = python_loop_with_decisions(scenario, settings, redesign, delay)
    assert run.decisions == tuple(decisions)
    assert decisions[-1].gains == redesign
    assert run.loop.u.tobytes() == np.ascontiguousarray(rows[:, 1]).tobytes()
    assert run.loop.measured.tobytes() == np.ascontiguousarray(rows[:, 2]).tobytes()


def test_without_simulation_nothing_is_decided():
    assert simulate_with_twin(SCENARIO, link=link(1.0)).decisions == ()


class KnowsTheGap:
    """States a constant gap once a second."""

    def __init__(self, gap):
        self._gap, self._second = gap, 0

    def restart(self):
        self._second = 0

    def update(self, batch, *, newest_only=False):
        second = int(batch[-1, 0])
        if second == self._second:
            return None
        self._second = second
        return Estimate(batch[-1, 0], self._gap, 0.0)


def test_a_decision_that_a_badly_damped_mechanism_belies_is_taken_back():
    """The twin believes in 40 % more damping than there is."""
    gap, believed = math.radians(15.0), PlantModel()
    structure = dataclasses.replace(believed.structure, damping=0.6 * believed.structure.damping)
    scenario = Scenario(
        40.0,
        ReferenceProfile(step_time=10.0),
        GapProfile("constant", gap),
        model=dataclasses.replace(believed, structure=structure),
    )
    settings = DecisionSettings(
        kind="simulate",
        members=3,
        period=10.0,
        step_heights=(5e-3,),
        step_time=10.0,
        patience=6.0,
    )
    run = simulate_with_twin(scenario, KnowsTheGap(gap), decision=settings, believed=believed)
    first, last = run.decisions[0], run.decisions[-1]
    assert (first.taken_back, last.taken_back) == (0, 1)
    assert "a decision was taken back: the loop has not rested" in last.reason
    assert first.tolerance < PITCH * gap
    assert run.tolerances[-1] == pytest.approx(PITCH * gap)
