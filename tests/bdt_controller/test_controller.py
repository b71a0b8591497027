"""The controller that runs: what it makes of reference, measurement and reconfiguration."""

import math
from dataclasses import replace

import pytest
from dead_zone_pid import dead_zone_pid_step

from bdt_controller.controller import ControllerSettings, DeadZoneController
from bdt_controller.notch import NO_NOTCH, NotchFilter
from bdt_controller.pid import INITIAL_PID, PidGains, discretize_pid

POSITIONS = [0.0, 1e-3, 4.99e-3, 5.0e-3, 5.2e-3, 4.0e-3]
WITH_DEAD_ZONE = ControllerSettings(dead_zone_tolerance=28e-6)


def test_every_step_is_a_step_of_the_dead_zone_pid_on_reference_minus_position():
    controller = DeadZoneController(PidGains(), WITH_DEAD_ZONE)
    state, step = INITIAL_PID, discretize_pid(PidGains(), 1 / 500)
    for position in POSITIONS:
        state, voltage = dead_zone_pid_step(state, 5e-3 - position, 28e-6, step)
        assert controller.step(5e-3, position) == voltage


def test_a_platform_that_is_too_low_is_pushed_up():
    controller = DeadZoneController(PidGains(2.0, 0.0, 0.0), ControllerSettings())
    assert controller.step(1.0, 0.0) == 2.0
    assert controller.step(0.0, 1.0) == -2.0


@pytest.mark.parametrize("control_rate", [100.0, 1000.0])
def test_the_integral_grows_with_time_and_not_with_the_number_of_steps(control_rate):
    gains, settings = PidGains(0.0, 3.0, 0.0), ControllerSettings(control_rate=control_rate)
    controller = DeadZoneController(gains, settings)
    for _ in range(round(control_rate)):
        voltage = controller.step(0.1, 0.0)
    assert voltage == pytest.approx(0.3, rel=1e-12)  # 3 V/(m s) times 0.1 m times 1 s


def settled(controller, reference, position):
    """Return the voltage once nothing is left of a switch, with the platform held."""
    return [controller.step(reference, position) for _ in range(1000)][-1]


def test_in_a_new_dead_zone_the_voltage_fades_from_the_next_step_on():
    controller, steady = (DeadZoneController(PidGains(), ControllerSettings()) for _ in range(2))
    assert controller.step(5e-3, 4.99e-3) == steady.step(5e-3, 4.99e-3)
    controller.configure(PidGains(), WITH_DEAD_ZONE)
    assert controller.step(5e-3, 4.99e-3) == steady.step(5e-3, 4.99e-3) != 0.0
    assert settled(controller, 5e-3, 4.99e-3) == 0.0
    assert controller.step(5e-3, 4.95e-3) != 0.0


def test_a_reconfiguration_keeps_the_state():
    steady = DeadZoneController(PidGains(), ControllerSettings())
    reconfigured = DeadZoneController(PidGains(), ControllerSettings())
    for position in POSITIONS:
        reconfigured.configure(PidGains(), ControllerSettings())
        assert reconfigured.step(5e-3, position) == steady.step(5e-3, position)


def test_new_gains_keep_the_voltage_of_the_integral_and_act_on_what_comes():
    controller = DeadZoneController(PidGains(0.0, 3.0, 0.0), ControllerSettings())
    assert controller.step(1.0, 0.0) == pytest.approx(3.0 / 500)
    controller.configure(PidGains(0.0, 6.0, 0.0), ControllerSettings())
    assert settled(controller, 1.0, 1.0) == pytest.approx(3.0 / 500)
    assert controller.step(1.0, 0.0) == pytest.approx(9.0 / 500)


def test_new_gains_do_not_move_the_voltage():
    controller, steady = (DeadZoneController(PidGains(), ControllerSettings()) for _ in range(2))
    for position in POSITIONS:
        assert controller.step(5e-3, position) == steady.step(5e-3, position)
    controller.configure(PidGains(6000.0, 9000.0, 0.0, 0.01), ControllerSettings())
    assert controller.step(5e-3, 4.1e-3) == pytest.approx(steady.step(5e-3, 4.1e-3), rel=1e-12)
    assert controller.step(5e-3, 4.1e-3) != pytest.approx(steady.step(5e-3, 4.1e-3), rel=1e-3)


def test_what_is_set_before_the_first_step_acts_at_once():
    controller = DeadZoneController(PidGains(), ControllerSettings())
    controller.configure(PidGains(6000.0), WITH_DEAD_ZONE)
    fresh = DeadZoneController(PidGains(6000.0), WITH_DEAD_ZONE)
    for position in POSITIONS:
        assert controller.step(5e-3, position) == fresh.step(5e-3, position)


def test_a_filter_in_series_takes_its_frequency_out_of_the_voltage():
    plain, filtered = (
        DeadZoneController(PidGains(1.0, 0.0, 0.0), ControllerSettings(), notch)
        for notch in (NO_NOTCH, NotchFilter(27.0, 0.0, 0.5))
    )
    times = [step / 500 for step in range(4000)]
    wanted = [plain.step(math.sin(27.0 * time), 0.0) for time in times][-500:]
    passed = [filtered.step(math.sin(27.0 * time), 0.0) for time in times][-500:]
    assert max(map(abs, passed)) < 0.03 * max(map(abs, wanted))


def test_a_new_offset_comes_without_a_bump_and_is_what_the_motor_rests_with():
    controller = DeadZoneController(PidGains(), WITH_DEAD_ZONE)
    assert (controller.step(5e-3, 4.99e-3), controller.resting_voltage) == (0.0, 0.0)
    offset = replace(WITH_DEAD_ZONE, voltage_offset=-0.02)
    controller.configure(PidGains(), offset)
    assert controller.step(5e-3, 4.99e-3) == 0.0
    assert (settled(controller, 5e-3, 4.99e-3), controller.resting_voltage) == (-0.02, -0.02)


def test_a_reset_forgets_the_past():
    controller = DeadZoneController(PidGains(), WITH_DEAD_ZONE)
    first = [controller.step(5e-3, position) for position in POSITIONS]
    controller.reset()
    assert [controller.step(5e-3, position) for position in POSITIONS] == first


@pytest.mark.parametrize(
    ("fault", "text"),
    [
        ({"dead_zone_tolerance": -1e-9}, r"dead_zone_tolerance = -1e-09 m: must be 0 to 0\.1 m"),
        ({"dead_zone_tolerance": 0.2}, r"dead_zone_tolerance = 0\.2 m: must be 0 to 0\.1 m"),
        ({"dead_zone_tolerance": float("nan")}, r"dead_zone_tolerance = nan m: must be 0 to 0\.1"),
        ({"dead_zone_tolerance": True}, r"dead_zone_tolerance = True: must be a number, 0 to 0\.1"),
        ({"voltage_offset": -10.1}, r"voltage_offset = -10\.1 V: must be -10 to 10 V"),
        ({"voltage_offset": float("nan")}, r"voltage_offset = nan V: must be -10 to 10 V"),
        ({"voltage_offset": "0"}, r"voltage_offset = '0': must be a number, -10 to 10 V"),
        (
            {"voltage_offset": -3.0, "voltage_limit": 2.0},
            r"voltage_offset = -3\.0 V: must be within voltage_limit \(2 V\)",
        ),
        ({"control_rate": 0.0}, r"control_rate = 0\.0 Hz: must be 0\.1 to 1e\+06 Hz"),
        ({"control_rate": float("inf")}, r"control_rate = inf Hz: must be 0\.1 to 1e\+06 Hz"),
    ],
)
def test_a_fault_is_named_with_its_value_and_what_is_allowed(fault, text):
    with pytest.raises(ValueError, match=r"^ControllerSettings\." + text):
        ControllerSettings(**fault)
