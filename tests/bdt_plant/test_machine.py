"""The whole mechanism against a simulation by brute force, and its limits in closed form."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bdt_plant.amplifier_lag import AmplifierLag
from bdt_plant.cogging import CoggingParameters
from bdt_plant.compiled_period import compiled_period_of
from bdt_plant.gap_profile import GapProfile
from bdt_plant.machine import (
    MACHINE_AT_REST,
    discretize_machine,
    hold_machine_period,
    machine_step,
)
from bdt_plant.motor import MotorParameters
from bdt_plant.plant import AT_REST as PLANT_AT_REST
from bdt_plant.plant import PlantModel, Sampling, discretize_plant, hold_period
from bdt_plant.plant_simulator import PlantSimulator
from bdt_plant.pushes import PushParameters
from bdt_plant.screw_load import ScrewMechanics
from bdt_plant.stiffening_tower import BeamParameters
from bdt_plant.stribeck import StribeckParameters

# Table 1, written again so that a wrong default is seen.
J, L, R, K_T, K_B = 5e-6, 1e-3, 12.0, 0.8, 0.1
MASS, K, C, PITCH = 5.2, 1e4, 36.9, 1e-3 / (2 * math.pi)
RATE, HOLD, FINE = 5000.0, 10, 1e-6
TIMES = np.arange(150) * HOLD / RATE
VOLTAGES = (6.0 * np.sin(13 * TIMES) + 0.5 * np.cos(70 * TIMES)).tolist()

EVERYTHING = PlantModel(
    MotorParameters(coulomb_friction=0.01, viscous_friction=1e-5),
    stribeck=StribeckParameters(0.016, 2.0, 0.1),
    cogging=CoggingParameters(3e-3),
    screw_mechanics=ScrewMechanics(0.4, 1e6, 1e-5),
    beams=BeamParameters(2e6),
    pushes=PushParameters(2.0, 0.05, 0.1, 2),
    amplifier=AmplifierLag(2e-3),
)
EFFECTS = {
    "stribeck": PlantModel(
        MotorParameters(coulomb_friction=0.01), stribeck=StribeckParameters(0.016)
    ),
    "asymmetry": PlantModel(
        MotorParameters(coulomb_friction=0.01), stribeck=StribeckParameters(0.0, 2.0, 0.3)
    ),
    "cogging": PlantModel(cogging=CoggingParameters(3e-3)),
    "load": PlantModel(screw_mechanics=ScrewMechanics(0.4)),
    "elastic screw": PlantModel(screw_mechanics=ScrewMechanics(0.0, 1e6)),
    "thread": PlantModel(screw_mechanics=ScrewMechanics(thread_error=1e-5)),
    "stiffening beams": PlantModel(beams=BeamParameters(5e8)),
    "pushes": PlantModel(pushes=PushParameters(2.0, 0.05, 0.1, 3)),
    "lag": PlantModel(amplifier=AmplifierLag(1.5e-3)),
    "everything": EVERYTHING,
}


def run(model, gap, voltages=VOLTAGES, sub_steps=10, period=hold_machine_period):
    """Return q3 [m] at every sample and the last state."""
    step, state = discretize_machine(model, Sampling(sub_steps=sub_steps)), MACHINE_AT_REST
    state = state._replace(contact=0 if gap else 1)
    positions = np.empty((len(voltages), HOLD))
    for voltage, row in zip(voltages, positions, strict=True):
        state = period(state, float(voltage), np.full(HOLD, gap), step, row)
    return positions.ravel(), state


def brute_force(model, gap):
    """Return q3 [m] at every sample, by Euler's method with steps of a microsecond."""
    motor, friction, screw = model.motor, model.stribeck, model.screw_mechanics
    coulomb, asymmetry = motor.coulomb_friction, friction.friction_asymmetry
    excess = max(friction.static_friction - coulomb, 0.0)
    eta, k_d, k_3 = screw.efficiency, screw.stiffness, model.beams.cubic_stiffness
    cogging, push, steps = model.cogging, model.pushes, round(1 / RATE / FINE)
    gone = -math.expm1(-FINE / model.amplifier.lag) if model.amplifier.lag else 1.0
    u = i = w = theta = theta_d = q1 = v1 = q2 = v2 = q3 = v3 = 0.0
    positions = []
    for sample in range(len(VOLTAGES) * HOLD):
        command, time = VOLTAGES[sample // HOLD], sample / RATE + 1e-9
        force = 0.0
        if push.force and time > push.period and time % push.period < push.duration:
            force = push.force * (1 if time // push.period % 2 else -1)
        for _ in range(steps):
            u += gone * (command - u)
            size = coulomb + excess * math.exp(-((w / friction.stribeck_speed) ** 2))
            ahead, back = size * (1 + asymmetry), size * (1 - asymmetry)
            d_before = PITCH * theta_d + screw.thread_error * math.sin(theta_d)
            base = q1 if k_d else d_before
            bent, upper = base - q2, q2 - q3
            lower_force = K * bent + k_3 * bent**3
            if eta and gap and abs(theta - theta_d) >= gap / 2 * (1 - 1e-12):
                side = 1 if theta > theta_d else -1
                pushed = k_d * (d_before - q1) if k_d else lower_force + C * (PITCH * w - v2)
                if side * pushed > 0:
                    ahead += PITCH * pushed / eta if side > 0 else 0.0
                    back -= PITCH * pushed / eta if side < 0 else 0.0
            i += FINE / L * (u - R * i - K_B * w)
            free = w + FINE / J * (
                K_T * i
                - motor.viscous_friction * w
                - cogging.cogging_torque * math.sin(cogging.cogging_periods * theta)
            )
            w = free - FINE / J * min(max(free * J / FINE, -back), ahead)
            theta += FINE * w
            theta_d = min(max(theta_d, theta - gap / 2), theta + gap / 2)
            d = PITCH * theta_d + screw.thread_error * math.sin(theta_d)
            if k_d:
                lower_force += C * (v1 - v2)
                v1 += FINE / MASS * (k_d * (d - q1) - lower_force)
                q1 += FINE * v1
            else:
                lower_force += C * ((d - d_before) / FINE - v2)
            upper_force = K * upper + k_3 * upper**3 + C * (v2 - v3)
            v2 += FINE / MASS * (lower_force - upper_force + (force if push.platform == 2 else 0))
            v3 += FINE / MASS * (upper_force + (force if push.platform == 3 else 0))
            q2 += FINE * v2
            q3 += FINE * v3
        positions.append(q3)
    return np.array(positions)


@pytest.mark.parametrize("effect", EFFECTS)
def test_each_effect_moves_platform_3_as_a_simulation_by_brute_force_says(effect):
    """Within 0.1 um of 2 mm, which is the error of Euler's method."""
    expected = brute_force(EFFECTS[effect], 0.2)
    period = compiled_period_of(EFFECTS[effect])
    actual, _ = run(EFFECTS[effect], 0.2, period=period)
    paper, _ = run(PlantModel(), 0.2, period=period)
    error, matters = np.abs(actual - expected).max(), np.abs(paper - expected).max()
    assert error < 1e-7
    assert matters > 10 * error


def test_the_error_of_a_motion_without_events_is_of_second_order_in_the_step():
    """Without gap and dry friction, forward, against DOP853."""
    model = PlantModel(
        cogging=CoggingParameters(3e-3),
        screw_mechanics=ScrewMechanics(1.0, 1e6),
        beams=BeamParameters(1e8),
    )

    def rates(_t, x):
        i, w, theta, q1, v1, q2, v2, q3, v3 = x
        force, bent, upper = 1e6 * (PITCH * theta - q1), q1 - q2, q2 - q3
        lower_force = K * bent + 1e8 * bent**3 + C * (v1 - v2)
        upper_force = K * upper + 1e8 * upper**3 + C * (v2 - v3)
        torque = K_T * i - 3e-3 * math.sin(24 * theta) - PITCH * force
        return [
            (2.0 - R * i - K_B * w) / L,
            torque / J,
            w,
            v1,
            (force - lower_force) / MASS,
            v2,
            (lower_force - upper_force) / MASS,
            v3,
            upper_force / MASS,
        ]

    times = np.arange(1, 501) / RATE
    options = {"rtol": 1e-11, "atol": 1e-15, "max_step": 1e-4}
    reference = solve_ivp(rates, (0.0, 0.1), np.zeros(9), "DOP853", times, **options).y[7]
    errors = [
        np.abs(run(model, 0.0, [2.0] * 50, sub_steps)[0] - reference).max()
        for sub_steps in (5, 10, 20)
    ]
    assert errors[1] < 1e-8
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.3)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.3)


@pytest.mark.parametrize("gap", [0.0, 0.2])
def test_with_coulomb_s_friction_alone_it_is_the_paper_s_mechanism(gap):
    model = PlantModel(MotorParameters(coulomb_friction=0.02, viscous_friction=1e-5))
    assert model.is_piecewise_linear
    step, state = discretize_plant(model, 1 / RATE), PLANT_AT_REST._replace(contact=not gap)
    expected = np.empty((len(VOLTAGES), HOLD))
    for voltage, row in zip(VOLTAGES, expected, strict=True):
        state = hold_period(state, voltage, np.full(HOLD, gap), step, row)
    actual, _ = run(model, gap, sub_steps=40)
    assert np.abs(actual - expected.ravel()).max() < 1e-7


def test_a_motor_that_sticks_stays_where_it_is_to_the_last_bit():
    """R tau_s / k_T = 0.24 V do not move it; what does move it meets less friction."""
    model = EFFECTS["stribeck"]
    _, stuck = run(model, 0.2, [0.239] * 200)
    assert (stuck.motor.angle, stuck.motor.speed) == (0.0, 0.0)
    _, moved = run(model, 0.2, [0.4] * 100)
    speed = moved.motor.speed
    friction = 0.01 + 0.006 * math.exp(-((speed / 2.0) ** 2))
    assert speed == pytest.approx((0.4 - R * friction / K_T) / K_B, rel=1e-4)


def test_steady_speeds_of_both_directions_are_those_of_their_friction():
    model = EFFECTS["asymmetry"]
    for voltage, torque in ((2.0, 0.013), (-2.0, -0.007)):
        _, state = run(model, 0.2, [voltage] * 50)
        assert state.motor.speed == pytest.approx((voltage - R * torque / K_T) / K_B, rel=1e-6)


def test_a_motor_without_voltage_comes_to_rest_where_cogging_draws_it():
    _, state = run(EFFECTS["cogging"], 0.2, [0.3] * 3 + [0.0] * 800)
    periods = state.motor.angle / (2 * math.pi / 24)
    assert periods == pytest.approx(round(periods), abs=1e-6)


def test_an_elastic_screw_gives_way_and_a_rigid_one_does_not():
    step, state = discretize_machine(EVERYTHING, Sampling()), MACHINE_AT_REST
    for _ in range(200):
        state = machine_step(state, 6.0, 0.0, step)
    assert abs(state.structure.q1 - PITCH * state.theta_d) > 1e-6
    _, rigid = run(EFFECTS["load"], 0.2)
    assert rigid.structure.q1 == PITCH * rigid.theta_d


@pytest.mark.parametrize("effect", ["everything", "load"])
def test_a_simulator_compiled_or_not_gives_the_same_floats(effect):
    runs = []
    for period in (None, compiled_period_of(EFFECTS[effect])):
        profile = GapProfile(growth_time=0.2)
        simulator = PlantSimulator(EFFECTS[effect], profile, Sampling(), period=period)
        rows = np.concatenate([simulator.advance(u) for u in VOLTAGES])
        runs.append((rows.tobytes(), simulator.truth()))
    assert runs[0] == runs[1]
    positions = runs[0][1][-3:]
    assert len(set(positions)) == 3


@pytest.mark.parametrize("effect", EFFECTS)
def test_each_effect_alone_is_enough_to_leave_the_paper_s_mechanism(effect):
    assert not EFFECTS[effect].is_piecewise_linear


def test_what_has_no_effect_does_not_cost_time():
    quiet = replace(
        PlantModel(),
        stribeck=StribeckParameters(friction_asymmetry=0.3),
        pushes=PushParameters(seed=3),
    )
    assert quiet.is_piecewise_linear
