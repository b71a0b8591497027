"""A machine is found from a minute of telemetry, on an independent simulation of it."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
import yaml
from recorded_loops import Messages
from recorded_machine import Proportional, Run, record
from unknown_machine import UnknownMachine

from bdt_bringup.cli import run_command
from bdt_bringup.configuration import load_configuration
from bdt_controller.commissioning import level_at
from bdt_msgs_py.command_errors import BAD_INPUT
from bdt_study.calibration.calibrate import calibrate
from bdt_study.calibration.calibrated_configuration import (
    calibrated_configuration,
    configuration_text,
)
from bdt_study.calibration.constant import HELD
from bdt_study.calibration.start_values import model_values, read_configuration

GAP = math.radians(12.0)
MACHINE = UnknownMachine(coulomb_friction=10e-3, amplifier_offset=20e-3, delay=0.5e-3)
START = """
/**/twin:
  ros__parameters:
    motor: {back_emf_constant: 0.19}
    structure: {stiffness: 5200.0, damping: 70.0}
/**/controller:
  ros__parameters:
    voltage_limit: 24.0
"""


def commissioning(time, travel=5e-3, speed=20e-3):
    return travel * level_at(time, travel / speed)


def telemetry(machine, duration, reference=commissioning):
    """Return telemetry rows (t [s], u [V], q3 [m]) of a machine that follows a reference."""
    run = Run(duration, sampling_rate=5000.0, first_gap=GAP, last_gap=GAP)
    return record(machine, run, Proportional(900.0), reference).rows


def bag_of(path, rows, batch=500):
    messages = Messages()
    messages.telemetry(rows, batch)
    return messages.write(path)


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return bag_of(tmp_path_factory.mktemp("machine") / "bag", telemetry(MACHINE, 36.0))


@pytest.fixture(scope="module")
def start(tmp_path_factory):
    path = tmp_path_factory.mktemp("start") / "start.yaml"
    path.write_text(START)
    return path


@pytest.fixture(scope="module")
def result(bag, start):
    return calibrate(bag, read_configuration(start))


@pytest.mark.parametrize(
    ("name", "truth", "tolerance"),
    [
        ("motor.back_emf_constant", 0.1, 1e-4),
        ("motor.coulomb_friction", 10e-3, 2e-5),
        ("friction_voltage", 0.15, 3e-4),
        ("structure.stiffness", 1e4, 10.0),
        ("structure.damping", 36.9, 0.2),
        ("actuator.offset", 20e-3, 2e-4),
        # The simulation of the machine leads an exact one by two of its steps.
        ("sensor.delay", 0.5e-3, 0.06e-3),
        ("sensor.drift", 0.0, 1e-7),
        ("gap.initial", GAP, math.radians(0.05)),
    ],
)
def test_what_the_data_tell_is_found_from_values_off_by_a_factor_of_two(
    result, name, truth, tolerance
):
    found = result.constants[name]
    assert found.determined
    assert found.value == pytest.approx(truth, abs=tolerance)
    assert abs(found.value - truth) < 3.0 * found.standard_uncertainty


def test_what_they_do_not_tell_keeps_its_value_and_is_named_with_what_would(result):
    for name in HELD:
        found = result.constants[name]
        assert not found.determined
        assert found.revealed_by
    assert result.constants["structure.mass"].value == 5.2


def test_what_is_told_as_a_ratio_is_as_unsure_as_its_other_part(result):
    stiffness, mass = result.constants["structure.stiffness"], result.constants["structure.mass"]
    relative = mass.standard_uncertainty / mass.value
    assert stiffness.given == ("structure.mass",)
    assert stiffness.standard_uncertainty / stiffness.value == pytest.approx(relative, rel=0.01)
    assert stiffness.standard_uncertainty_given < 0.01 * stiffness.standard_uncertainty


def test_the_residual_is_the_noise_in_the_half_that_was_not_fitted_as_well(result):
    assert result.residual.rms == pytest.approx(MACHINE.noise, rel=0.05)
    assert result.validation.rms == pytest.approx(MACHINE.noise, rel=0.05)
    assert result.validation.times[0] > 0.4 * result.residual.times[-1]


STICKING = replace(MACHINE, friction_at_rest=16e-3, stribeck_speed=3.0)


@pytest.fixture(scope="module")
def sticking(tmp_path_factory, start):
    bag = bag_of(tmp_path_factory.mktemp("sticking") / "bag", telemetry(STICKING, 36.0))
    return calibrate(bag, read_configuration(start))


@pytest.mark.parametrize(
    ("name", "truth", "tolerance"),
    [
        ("motor.back_emf_constant", 0.1, 1e-4),
        ("motor.coulomb_friction", 10e-3, 2e-5),
        ("motor.static_friction", 16e-3, 4e-5),
        ("motor.stribeck_speed", 3.0, 0.02),
        ("structure.stiffness", 1e4, 10.0),
        ("structure.damping", 36.9, 0.2),
        ("actuator.offset", 20e-3, 2e-4),
        ("gap.initial", GAP, math.radians(0.05)),
    ],
)
def test_so_is_a_motor_that_sticks(sticking, name, truth, tolerance):
    found = sticking.constants[name]
    assert found.determined
    assert found.value == pytest.approx(truth, abs=tolerance)
    assert abs(found.value - truth) < 3.0 * found.standard_uncertainty


def test_a_motor_that_sticks_leaves_nothing_but_noise_either(sticking):
    assert sticking.residual.rms == pytest.approx(STICKING.noise, rel=0.05)
    assert sticking.validation.rms == pytest.approx(STICKING.noise, rel=0.05)
    assert sticking.unexplained == ""


def test_friction_at_rest_is_what_plant_and_twin_are_told_of(sticking):
    found = calibrated_configuration(None, model_values(sticking.start), sticking.constants)
    assert found["plant"]["motor.static_friction"] == pytest.approx(16e-3, rel=0.01)
    assert found["plant"]["motor.stribeck_speed"] == pytest.approx(3.0, rel=0.01)


def test_a_motor_in_which_none_was_found_loses_that_of_the_start_values(result):
    before = {"plant": {"motor.static_friction": 0.3}, "controller": {}, "twin": {}}
    constants = {
        name: each for name, each in result.constants.items() if name != "motor.static_friction"
    }
    found = calibrated_configuration(before, model_values(result.start), constants)
    assert "motor.static_friction" not in found["plant"]


def test_a_motor_that_moves_one_way_tells_neither_friction_nor_offset_nor_gap(tmp_path, start):
    rows = telemetry(MACHINE, 15.0, lambda time: 2e-3 * max(time - 1.0, 0.0))
    result = calibrate(bag_of(tmp_path / "bag", rows), read_configuration(start))
    assert result.constants["motor.back_emf_constant"].determined
    for name in ("motor.coulomb_friction", "actuator.offset", "gap.initial"):
        assert not result.constants[name].determined
        assert result.constants[name].revealed_by


def test_a_gap_that_is_not_told_is_in_no_file(result):
    gap = replace(result.constants["gap.initial"], determined=False)
    constants = result.constants | {"gap.initial": gap}
    before = {"plant": {"gap.kind": "ramp", "gap.initial": 0.1}, "twin": {}}
    before["controller"] = {"dead_zone_tolerance": 5e-5}
    found = calibrated_configuration(before, model_values(result.start), constants)
    assert found["plant"]["gap.kind"] == "ramp"
    assert found["plant"]["gap.initial"] == 0.1
    assert found["controller"]["dead_zone_tolerance"] == 5e-5


def test_a_model_that_leaves_much_of_the_motion_tells_nothing_and_says_so(tmp_path, start, capsys):
    # One step of a motor that sticks: no window in which it reverses tells one from the other.
    run = Run(20.0, sampling_rate=5000.0, first_gap=GAP, last_gap=GAP, step_time=100.0)
    bag = bag_of(tmp_path / "bag", record(replace(MACHINE, friction_at_rest=16e-3), run).rows)
    result = calibrate(bag, read_configuration(start))
    assert "does not explain" in result.unexplained
    assert not any(each.determined for each in result.constants.values())
    report = tmp_path / "report"
    assert (
        run_command(["calibrate", str(bag), "--config", str(start), "--report", str(report)]) == 0
    )
    assert result.unexplained in capsys.readouterr().out
    page = (report / "report.html").read_text()
    assert result.unexplained in page
    assert "The gap is not told" in page


def test_files_and_json_of_the_command(bag, start, tmp_path, capsys):
    output, report = tmp_path / "calibrated.yaml", tmp_path / "report"
    options = ["--config", start, "--output", output, "--report", report, "--json"]
    # Less is looked at than there is, and still enough.
    arguments = ["calibrate", bag, *options, "--seconds", "20", "--known", "structure.mass"]
    assert run_command([str(each) for each in arguments]) == 0
    said = json.loads(capsys.readouterr().out)
    stiffness = said["parameters"]["structure.stiffness"]
    assert stiffness["determined"]
    assert stiffness["unit"] == "N/m"
    assert stiffness["standard_uncertainty"] < 10.0
    assert said["gap_standard_uncertainty_rad"] < math.radians(0.2)
    assert abs(said["gap_rad"] - GAP) < 2.0 * said["gap_standard_uncertainty_rad"]
    assert said["unexplained"] == ""
    assert said["delay_s"] == said["parameters"]["sensor.delay"]["value"]
    assert said["validation_rms_m"] < 2.0 * said["residual_rms_m"]
    configuration = load_configuration(output)
    for node in ("plant", "twin"):
        assert configuration.value(node, "motor.back_emf_constant") == pytest.approx(0.1, abs=1e-3)
        assert configuration.value(node, "motor.coulomb_friction") == pytest.approx(0.01, abs=1e-4)
    assert configuration.value("plant", "gap.kind") == "constant"
    assert configuration.value("controller", "voltage_offset") == pytest.approx(-0.02, abs=1e-3)
    assert configuration.value("plant", "actuator.offset") == pytest.approx(0.02, abs=1e-3)
    assert configuration.value("plant", "sensor.delay") == pytest.approx(0.5e-3, abs=1e-4)
    assert configuration.value("controller", "voltage_limit") == 24.0
    assert configuration.value("controller", "dead_zone_tolerance") == pytest.approx(
        GAP * 1e-3 / (2 * math.pi), rel=0.05
    )
    page = (report / "report.html").read_text()
    assert page.count("<svg") == 2
    for text in ("structure.mass", "Correlations", "would be told by"):
        assert text in page


def test_what_a_file_says_of_a_driver_is_kept_beside_the_machine_that_was_found(result, tmp_path):
    path = tmp_path / "machine.yaml"
    path.write_text(START + "/**/driver: {ros__parameters: {drive: {port: x, gain: 2}}}\n")
    before = read_configuration(path)
    found = calibrated_configuration(before, model_values(result.start), result.constants)
    text = configuration_text(found, "bag", result.constants)
    assert yaml.safe_load(text)["/**/driver"] == {
        "ros__parameters": {"drive": {"port": "x", "gain": 2}}
    }
    assert {"/**/plant", "/**/controller", "/**/twin"} < set(yaml.safe_load(text))


def resting_rows(duration):
    rows = np.zeros((round(duration * 5000), 3))
    rows[:, 0] = np.arange(len(rows)) / 5000.0
    return rows


def held_rows(duration):
    """Return telemetry of a motor that is too weak for what holds it."""
    return telemetry(UnknownMachine(coulomb_friction=1.0, noise=0.0), duration)


@pytest.mark.parametrize(
    ("rows", "options", "reason"),
    [
        (
            lambda: resting_rows(20.0),
            [],
            "the motor does not move: its voltage is 0 V",
        ),
        (
            lambda: held_rows(20.0),
            [],
            "the platform moves over 0 um: must be at least 159 um, a radian of the screw",
        ),
        (
            lambda: telemetry(MACHINE, 6.0),
            [],
            "6 s of telemetry without holes: must be at least 10 s",
        ),
        (None, ["--seconds", "2"], "--seconds 2: must be 10 to 600"),
        (None, ["--known", "structure.mas"], "did you mean structure.mass?"),
        (None, ["--config", "missing.yaml"], "--config missing.yaml: cannot be read"),
        (None, ["--config", "/dev/null"], "--config /dev/null: is a device: must be a file"),
    ],
)
def test_what_cannot_be_used_is_one_line(bag, tmp_path, capsys, rows, options, reason):
    given = bag
    if rows is not None:
        given = bag_of(tmp_path / "bag", rows())
    assert run_command(["calibrate", str(given), *options]) == BAD_INPUT
    said = capsys.readouterr().err
    assert reason in said
    assert said.count("\n") == 1


def test_telemetry_that_is_none_of_a_mechanism_is_refused(tmp_path, capsys):
    generator = np.random.default_rng(1)
    rows = resting_rows(10.0)
    rows[:, 1] = np.repeat(generator.standard_normal(100), 500)
    rows[:, 2] = 1e-3 * np.repeat(generator.standard_normal(500), 100)
    assert run_command(["calibrate", str(bag_of(tmp_path / "bag", rows))]) == BAD_INPUT
    said = capsys.readouterr().err
    assert "the model does not explain" in said
    assert said.count("\n") == 1


def test_a_bag_without_telemetry_is_refused(tmp_path, capsys):
    messages = Messages()
    messages.reference(0.0, 1e-3)
    path = messages.write(tmp_path / "bag")
    assert run_command(["calibrate", str(path)]) == BAD_INPUT
    assert capsys.readouterr().err.count("\n") == 1
