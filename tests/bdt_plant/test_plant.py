"""The whole plant against its continuous equations, solved with event detection."""

import math

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bdt_plant.actuator import ActuatorParameters
from bdt_plant.gap_profile import GapProfile, gap_at
from bdt_plant.motor import MotorParameters, MotorState
from bdt_plant.plant import AT_REST, PlantModel, PlantState, Sampling, discretize_plant, plant_step
from bdt_plant.plant_simulator import PlantSimulator
from bdt_plant.sensor import Sensor, SensorParameters
from bdt_plant.structure import StructureState

# Table 1, written again so that a wrong default is seen.
J, L, R, K_T, K_B = 5e-6, 1e-3, 12.0, 0.8, 0.1
M, K, C = 5.2, 1e4, 36.9
PITCH = 1e-3 / (2 * math.pi)
RATE = 5000
HOLD = 10  # samples for which the controller holds a voltage
TEN_DEGREES = math.radians(10.0)


def equations(*, screw_moves):
    """Return A and b of eqs 1, 2, 3 for (i, w_m, theta_m, theta_d, q2, q2', q3, q3')."""
    a = np.zeros((8, 8))
    a[0, 0], a[0, 1] = -R / L, -K_B / L
    a[1, 0] = K_T / J
    a[2, 1] = 1.0
    a[3, 1] = float(screw_moves)  # eq. 6: omega_d = omega_m or 0
    a[4, 5] = a[6, 7] = 1.0
    # q1 = p theta_d, and the damper feels its velocity p omega_d.
    a[5, [3, 4, 5, 6, 7]] = np.array([K * PITCH, -2 * K, -2 * C, K, C]) / M
    a[5, 1] = C * PITCH / M * screw_moves
    a[7, [4, 5, 6, 7]] = np.array([K, C, -K, -C]) / M
    b = np.zeros(8)
    b[0] = 1 / L
    return a, b


def solve(voltages, gap, start):
    """Return the states at the samples for voltages held for HOLD samples each, with eq. 6."""
    contact, free = equations(screw_moves=True), equations(screw_moves=False)

    def mode_of(x):
        if gap == 0:
            return contact
        play = x[2] - x[3]
        if (x[1] > 0 and play >= gap / 2 - 1e-12) or (x[1] < 0 and play <= -gap / 2 + 1e-12):
            return contact
        return free

    def closes(_time, x):
        return abs(x[2] - x[3]) - gap / 2 - 1e-13

    def turns(_time, x):
        return x[1]

    closes.terminal = turns.terminal = True
    closes.direction = 1
    state, states = np.array(start), [start]
    for voltage in voltages:
        # Solved from sample to sample: the events are then too close together to be missed.
        for _ in range(HOLD):
            time = 0.0
            while time < 1 / RATE:
                a, b = mode = mode_of(state)
                event = turns if mode is contact else closes
                # Do not stop again at the instant just passed.
                turns.direction = -math.copysign(1.0, state[1])
                solution = solve_ivp(
                    lambda _t, x, a=a, b=b * voltage: a @ x + b,
                    (time, 1 / RATE),
                    state,
                    "DOP853",
                    rtol=1e-10,
                    atol=1e-14,
                    events=event if gap > 0 else None,
                )
                time, state = solution.t[-1], solution.y[:, -1]
                if solution.status == 1 and mode is contact:
                    state[1] = 0.0
            states.append(state)
    return np.array(states)


def simulate(voltages, profile, start=AT_REST):
    """Return the states of the core at the same samples."""
    step = discretize_plant(PlantModel(), 1 / RATE)
    state, states = start, [start]
    for sample in range(len(voltages) * HOLD):
        gap = gap_at(profile, (sample + 1) / RATE)
        state = plant_step(state, voltages[sample // HOLD], gap, step)
        states.append(state)
    return np.array([(*s.motor, s.theta_d, *s.structure) for s in states])


def smooth_voltages(count):
    """Return voltages like those of the closed loop: 15 V, turning some times a second."""
    times = np.arange(count) * HOLD / RATE
    return (15 * np.sin(25 * times) * np.cos(4 * times)).tolist()


def rough_voltages(count):
    """Return voltages that jump by up to 24 V at every command, worse than any closed loop."""
    return np.random.default_rng(4).uniform(-12, 12, count).tolist()


hold_cases = pytest.mark.parametrize(
    "voltages", [smooth_voltages(200), rough_voltages(200)], ids=["smooth", "rough"]
)


@hold_cases
def test_without_backlash_q3_is_exact(voltages):
    """To the tolerance of the reference; a straight line for d would be 2e-9 to 6e-9 m off."""
    core = simulate(voltages, GapProfile(kind="constant", initial=0.0), AT_REST._replace(contact=1))
    assert (core[:, 2] == core[:, 3]).all()
    reference = solve(voltages, 0.0, np.zeros(8))
    assert np.abs(core[:, 6] - reference[:, 6]).max() < 1e-11
    assert np.abs(core[:, 4] - reference[:, 4]).max() < 1e-11


def test_without_backlash_q3_is_that_of_eqs_1_2_and_3_in_series():
    eq_2 = control.tf([K_T], [J * L, J * R, K_B * K_T, 0])
    eq_3 = control.tf([C**2, 2 * C * K, K**2], [M**2, 3 * C * M, C**2 + 3 * K * M, 2 * C * K, K**2])
    times = np.arange(5001) / RATE
    expected = 12.0 * control.step_response(control.ss(eq_3 * PITCH * eq_2), times).outputs
    core = simulate([12.0] * 500, GapProfile(kind="constant", initial=0.0))
    assert np.abs(core[:, 6] - expected).max() < 1e-9


def test_in_steady_contact_q3_is_exact():
    voltages = [6.0 + 5.0 * math.sin(k / 8) for k in range(200)]  # the motor never turns back
    in_contact = AT_REST._replace(theta_d=-TEN_DEGREES / 2, contact=1)
    core = simulate(voltages, GapProfile(kind="constant", initial=TEN_DEGREES), in_contact)
    start = np.zeros(8)
    start[3] = -TEN_DEGREES / 2
    reference = solve(voltages, TEN_DEGREES, start)
    assert np.abs(core[:, 2] - core[:, 3] - TEN_DEGREES / 2).max() < 1e-13
    assert np.abs(core[:, 6] - reference[:, 6]).max() < 1e-11


def contact_changes(states, gap):
    play = states[:, 2] - states[:, 3]
    side = np.where(play > gap / 2 - 1e-9, 1, np.where(play < -gap / 2 + 1e-9, -1, 0))
    return int(np.count_nonzero(np.diff(side)))


@pytest.mark.parametrize(
    ("voltages", "tolerance"),
    [(smooth_voltages(300), 1e-8), (rough_voltages(300), 1e-7)],
    ids=["smooth", "rough"],
)
def test_across_contact_changes_q3_is_right_to_tens_of_nanometers(voltages, tolerance):
    """A turn of the motor between two samples is not seen: 7e-6 rad, or 7e-4 rad when rough."""
    core = simulate(voltages, GapProfile(kind="constant", initial=TEN_DEGREES))
    reference = solve(voltages, TEN_DEGREES, np.zeros(8))
    assert contact_changes(core, TEN_DEGREES) >= 8
    assert np.abs(core[:, 6] - reference[:, 6]).max() < tolerance


def test_the_base_of_the_structure_is_the_pitch_times_the_angle_of_the_screw():
    simulator = PlantSimulator(PlantModel(), GapProfile(), Sampling())
    for _ in range(100):
        simulator.advance(12.0)
    names = ("time", "theta_m", "theta_d", "gap", "q1", "q2", "q3")
    truth = dict(zip(names, simulator.truth(), strict=True))
    assert truth["q1"] == pytest.approx(PITCH * truth["theta_d"], rel=1e-15)  # eq. 1
    assert truth["time"] == simulator.time
    assert truth["gap"] == gap_at(GapProfile(), simulator.time)
    assert truth["q3"] == simulator.position
    assert truth["theta_m"] - truth["theta_d"] == pytest.approx(truth["gap"] / 2, abs=1e-12)
    assert truth["q2"] == simulator.state.structure.q2


def test_rest_is_rest():
    simulator = PlantSimulator(PlantModel(), GapProfile(), Sampling())
    assert not simulator.advance(0.0)[:, 1:].any()
    assert simulator.state == AT_REST


def test_advance_returns_the_samples_from_the_command_up_to_the_next_measurement():
    sampling = Sampling(sampling_rate=1000.0, control_rate=250.0)
    simulator = PlantSimulator(PlantModel(), GapProfile(kind="constant"), sampling)
    positions, rows = [], []
    for voltage in (5.0, -7.0, 3.0):
        positions.append(simulator.position)
        rows.append(simulator.advance(voltage))
    assert [batch.shape for batch in rows] == [(4, 3)] * 3
    times, voltages, q3 = np.concatenate(rows).T
    assert times.tolist() == [sample / 1000 for sample in range(12)]
    assert voltages.tolist() == [5.0] * 4 + [-7.0] * 4 + [3.0] * 4
    assert q3[::4].tolist() == positions  # the first row is the measurement itself
    assert simulator.time == 0.012


def test_advance_takes_the_same_steps_as_plant_step():
    profile = GapProfile(growth_time=1.0)
    simulator = PlantSimulator(PlantModel(), profile, Sampling())
    voltages = smooth_voltages(50)
    q3 = np.concatenate([simulator.advance(voltage)[:, 2] for voltage in voltages])
    states = simulate(voltages, profile)
    assert q3.tolist() == states[:-1, 6].tolist()
    assert simulator.position == states[-1, 6]
    assert simulator.state.theta_d == states[-1, 3]


def test_measurement_and_telemetry_are_the_sensor_s_readings_and_truth_stays_true():
    parameters = SensorParameters(1e-6, 1e-7, 1e-3, 0.1, 2)
    noisy = PlantSimulator(PlantModel(), GapProfile(), Sampling(), parameters)
    clean = PlantSimulator(PlantModel(), GapProfile(), Sampling())
    sensor = Sensor(parameters, RATE)
    for voltage in smooth_voltages(100):
        measured, truth = noisy.position, noisy.truth()
        rows, true_rows = noisy.advance(voltage), clean.advance(voltage)
        assert rows[0, 2] == measured
        assert truth[-1] == true_rows[0, 2]
        assert rows[:, 2].tolist() == [sensor.read(q3) for q3 in true_rows[:, 2].tolist()]
    assert noisy.state == clean.state
    sensor.read(clean.position)  # the measurement that would come next
    assert noisy.dropped_samples == sensor.dropped > 50
    assert clean.dropped_samples == 0


def test_the_telemetry_s_voltage_is_the_command_and_the_motor_gets_what_the_amplifier_makes_of_it():
    actuator = ActuatorParameters(offset=0.05, gain=0.98, resolution=0.1)
    real = PlantSimulator(PlantModel(), GapProfile(), Sampling(), actuator=actuator)
    ideal = PlantSimulator(PlantModel(), GapProfile(), Sampling())
    for command, applied in ((0.0, 0.05), (3.04, 0.98 * 3.0 + 0.05), (-1.06, 0.05 - 0.98 * 1.1)):
        rows, expected = real.advance(command), ideal.advance(applied)
        assert set(rows[:, 1]) == {command}
        np.testing.assert_allclose(rows[:, 2], expected[:, 2], rtol=1e-12, atol=1e-18)
    assert real.saturated_steps == 0


def test_the_telemetry_s_voltage_is_within_the_limit_of_the_actuator():
    limited = PlantSimulator(
        PlantModel(), GapProfile(), Sampling(), actuator=ActuatorParameters(saturation=True)
    )
    free = PlantSimulator(PlantModel(), GapProfile(), Sampling())
    for voltage, applied in ((60.0, 48.0), (47.0, 47.0), (-1e9, -48.0), (48.0, 48.0)):
        rows = limited.advance(voltage)
        assert set(rows[:, 1]) == {applied}
        np.testing.assert_array_equal(rows, free.advance(applied))
    assert limited.saturated_steps == 2
    assert free.saturated_steps == 0


def test_a_rubbing_motor_that_does_not_turn_back_moves_q3_exactly():
    """Friction is then a constant torque, one more input of the same linear equations."""
    torque = 0.05
    step = discretize_plant(PlantModel(MotorParameters(coulomb_friction=torque)), 1 / RATE)
    turning = MotorState(0.1, 50.0, 0.0)
    state = AT_REST._replace(motor=turning, contact=1)
    a, b = equations(screw_moves=True)
    rubbing = np.zeros(8)
    rubbing[1] = -torque / J
    expected, errors, speeds = np.array([*turning, *[0.0] * 5]), [], []
    for k in range(100):
        voltage = 6.0 + 4.0 * math.sin(k / 8)
        for _ in range(HOLD):
            state = plant_step(state, voltage, 0.0, step)
        held = b * voltage + rubbing
        expected = solve_ivp(
            lambda _t, x, held=held: a @ x + held,
            (0.0, HOLD / RATE),
            expected,
            "DOP853",
            rtol=1e-11,
            atol=1e-15,
        ).y[:, -1]
        errors.append(abs(state.structure.q3 - expected[6]))
        speeds.append(expected[1])
    assert min(speeds) > 0
    # 1e-8 m if the structure were told of a motor on another way.
    assert max(errors) < 1e-11


def test_without_friction_the_step_is_that_of_a_motor_without_it_bit_for_bit():
    voltages = rough_voltages(50)
    little = PlantModel(MotorParameters(coulomb_friction=1e-30))
    steps = discretize_plant(PlantModel(), 1 / RATE), discretize_plant(little, 1 / RATE)
    assert steps[0].motor == steps[1].motor
    states = [AT_REST, AT_REST]
    for voltage in voltages:
        states = [
            plant_step(state, voltage, 0.1, step) for state, step in zip(states, steps, strict=True)
        ]
    # A friction of nothing goes the other way through the code and arrives at the same place.
    np.testing.assert_allclose(states[0].structure, states[1].structure, rtol=1e-9, atol=1e-18)


def test_a_step_uses_the_gap_at_its_end():
    step = discretize_plant(PlantModel(), 1 / RATE)
    loose = PlantState(MotorState(0.0, 0.0, 1.0), 0.0, 0, StructureState(0.0, 0.0, 0.0, 0.0))
    assert plant_step(loose, 0.0, 2.0, step).theta_d == 0.0
    assert plant_step(loose, 0.0, 1.5, step).theta_d == 0.25
    shrinking = GapProfile(kind="table", table_times=(0.0, 1 / RATE), table_gaps=(2.0, 1.0))
    simulator = PlantSimulator(PlantModel(), shrinking, Sampling(RATE, RATE))
    simulator.state = loose
    simulator.advance(0.0)
    assert simulator.state.theta_d == 0.5


def test_time_does_not_drift():
    simulator = PlantSimulator(PlantModel(), GapProfile(), Sampling())
    simulator.sample = 10**9 - 10  # two days and a half; adding 0.2 ms each would be 1 us off
    row = simulator.advance(0.0)[-1]
    assert row[0] == (10**9 - 1) / 5000
    assert simulator.time == 200_000.0
    assert simulator.nanoseconds == 200_000 * 10**9


def test_nanoseconds_are_those_of_the_time():
    simulator = PlantSimulator(PlantModel(), GapProfile(), Sampling(3000.0, 3000.0))
    assert simulator.nanoseconds == 0
    simulator.advance(0.0)
    assert simulator.nanoseconds == 333_333
    simulator.advance(0.0)
    assert simulator.nanoseconds == 666_667


@pytest.mark.parametrize(
    ("sampling_rate", "control_rate", "samples"),
    [(5000.0, 500.0, 10), (5000.0, 5000.0, 1), (5000.0, 0.1, 50_000), (1000, 8, 125)],
)
def test_a_control_rate_that_divides_the_sampling_rate_is_accepted(
    sampling_rate, control_rate, samples
):
    assert Sampling(sampling_rate, control_rate).samples_per_control_step == samples


@pytest.mark.parametrize(
    ("sampling_rate", "control_rate", "text"),
    [
        (5000.0, 300.0, r"control_rate = 300\.0 Hz: must divide sampling_rate \(5000 Hz\)"),
        (500.0, 5000.0, r"control_rate = 5000\.0 Hz: must divide sampling_rate \(500 Hz\)"),
        (0.0, 500.0, r"sampling_rate = 0\.0 Hz: must be 1 to 1e\+06 Hz"),
        (5000.0, 0.0, r"control_rate = 0\.0 Hz: must be 0\.1 to 1e\+06 Hz"),
        (5000.0, -500.0, r"control_rate = -500\.0 Hz: must be 0\.1 to 1e\+06 Hz"),
        (float("nan"), 500.0, r"sampling_rate = nan Hz: must be 1 to 1e\+06 Hz"),
        (float("inf"), 500.0, r"sampling_rate = inf Hz: must be 1 to 1e\+06 Hz"),
        ("5000", 500.0, r"sampling_rate = '5000': must be a number, 1 to 1e\+06 Hz"),
    ],
)
def test_other_rates_are_refused(sampling_rate, control_rate, text):
    with pytest.raises(ValueError, match=r"^Sampling\." + text):
        Sampling(sampling_rate, control_rate)
