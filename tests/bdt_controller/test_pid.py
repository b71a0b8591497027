"""The PID against eq. 4 of the paper, for errors that are constant between measurements."""

import math

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_controller.pid import (
    INITIAL_PID,
    SMALLEST_SIGNAL,
    PidGains,
    PidState,
    discretize_pid,
    pid_step,
)

PERIOD = 2e-3
K_P, K_I, K_D, T_F = 3080.0, 30800.0, -308.4, 0.074
EQ_4 = control.tf([K_P * T_F + K_D, K_P + K_I * T_F, K_I], [T_F, 1, 0])

gains = st.builds(
    PidGains,
    st.floats(-1e4, 1e4),
    st.floats(-1e4, 1e4),
    st.floats(-1e4, 1e4),
    st.floats(1e-3, 10.0),
)
errors = st.lists(st.floats(-1, 1), min_size=1, max_size=40)


def run(error, pid=None, period=PERIOD, state=INITIAL_PID):
    """Return voltages and states, one for each error."""
    step = discretize_pid(pid or PidGains(), period)
    voltages, states = [], []
    for value in error:
        state, voltage = pid_step(state, float(value), step)
        voltages.append(voltage)
        states.append(state)
    return np.array(voltages), states


def superposed_steps(error, pid, period):
    """Return C_PID(s) e at the ends of the periods, as a sum of step responses of eq. 4."""
    changes = np.diff(error, prepend=0.0)
    voltages = []
    for now in range(len(error)):
        age = (now + 1 - np.arange(now + 1)) * period
        response = (
            pid.proportional
            + pid.integral * age
            + pid.derivative / pid.filter_time * np.exp(-age / pid.filter_time)
        )
        voltages.append(float(changes[: now + 1] @ response))
    return np.array(voltages)


def random_errors(count):
    return np.random.default_rng(5).uniform(-5e-3, 5e-3, count)


def test_the_voltage_is_that_of_eq_4_for_errors_held_until_the_measurement():
    error = random_errors(1000)
    held = control.sample_system(control.ss(EQ_4), PERIOD, "zoh")
    # python-control holds each error from its instant on, here it was held up to its instant:
    # its output one period later, less what jumps at once with the next error.
    following = np.append(error, 0.0)
    response = control.forced_response(held, np.arange(1001) * PERIOD, following).outputs
    expected = response[1:] - (K_P + K_D / T_F) * np.diff(following)
    # Voltages of some 10 V; the rest is rounding over 1000 periods.
    np.testing.assert_allclose(run(error)[0], expected, rtol=0, atol=1e-10)


@given(errors, gains, st.floats(1e-4, 1.0))
def test_the_voltage_is_a_sum_of_step_responses_of_eq_4(error, pid, period):
    expected = superposed_steps(error, pid, period)
    gain = abs(pid.proportional) + abs(pid.integral) * 40 + abs(pid.derivative) / pid.filter_time
    # 40 errors of up to 1 m: rounding of the products, nothing else.
    assert np.abs(run(error, pid, period)[0] - expected).max() <= 1e-13 * (1 + 40 * gain)


def test_a_constant_error_gives_the_step_response_of_eq_4():
    times = np.arange(501) * PERIOD
    expected = 5e-3 * control.step_response(EQ_4, times).outputs
    np.testing.assert_allclose(run(np.full(500, 5e-3))[0], expected[1:], rtol=0, atol=1e-10)


def test_the_first_error_acts_on_the_voltage_at_once():
    decay = math.exp(-PERIOD / T_F)
    expected = 5e-3 * (K_P + K_I * PERIOD + K_D / T_F * decay)
    assert run([5e-3])[0][0] == pytest.approx(expected, rel=1e-14)


@given(errors, gains)
def test_a_zero_error_leaves_the_integral_alone(error, pid):
    _, states = run([*error, 0.0, 0.0, 0.0], pid)
    assert states[-1].integral == states[-2].integral == states[-4].integral


def test_without_error_only_the_integral_is_left():
    voltages, states = run(np.zeros(2000), state=PidState(1e-3, 5e-3))
    assert voltages[-1] == K_I * 1e-3
    assert states[-1].integral == 1e-3


@given(errors, gains)
def test_turning_all_signs_turns_the_voltage_exactly(error, pid):
    assert (run(error, pid)[0] == -run([-value for value in error], pid)[0]).all()


def test_the_filter_comes_to_exact_rest_and_never_becomes_subnormal():
    _, states = run(np.zeros(5000), state=PidState(0.0, 5e-3))
    filtered = np.array([state.filtered for state in states])
    assert filtered[-1] == 0.0
    assert filtered[filtered != 0.0].min() >= SMALLEST_SIGNAL


def open_loop(pid):
    """Return the loop of figure 1 with table 1, eqs 1 to 4 and no backlash."""
    motor = control.tf([0.8], [5e-9, 6e-5, 0.08, 0])
    m, k, c = 5.2, 1e4, 36.9
    structure = control.tf(
        [c**2, 2 * c * k, k**2], [m**2, 3 * c * m, c**2 + 3 * k * m, 2 * c * k, k**2]
    )
    t_f, k_p, k_i = pid.filter_time, pid.proportional, pid.integral
    controller = control.tf([k_p * t_f + pid.derivative, k_p + k_i * t_f, k_i], [t_f, 1, 0])
    return controller * motor * structure * 1e-3 / (2 * math.pi)


def test_the_default_gains_meet_what_the_paper_designed_for():
    """A bandwidth of 10 rad/s and a phase margin of at least 10 degrees; here 17."""
    margins = control.stability_margins(open_loop(PidGains()), returnall=True)
    phase_margins, crossovers = np.abs(margins[1]), margins[4]
    assert crossovers.min() == pytest.approx(10.0, abs=0.1)
    assert phase_margins.min() == pytest.approx(16.8, abs=0.5)


def test_the_loop_of_the_default_gains_is_stable():
    poles = control.feedback(open_loop(PidGains()), 1).poles()
    assert poles.real.max() < 0


@pytest.mark.parametrize("name", ["proportional", "integral", "derivative", "filter_time"])
@pytest.mark.parametrize("value", [float("nan"), float("inf"), -2e9, "1", None, True])
def test_a_gain_that_is_no_finite_number_is_refused(name, value):
    with pytest.raises(ValueError, match=rf"^PidGains\.{name} = .*must be .* to "):
        PidGains(**{name: value})


def test_a_filter_without_time_is_refused():
    with pytest.raises(ValueError, match=r"^PidGains\.filter_time = 0\.0 s: must be 1e-06 to 1000"):
        PidGains(filter_time=0.0)
