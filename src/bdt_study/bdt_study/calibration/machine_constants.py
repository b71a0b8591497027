"""All constants of a machine from what a fit has found out.

Voltage and position tell ratios only: the motor turns by the voltage less that of the friction,
over its back EMF, whatever the torques behind it; the structure follows its base by k/m and c/m;
and a motor that is slow to answer looks like a reading that is late. One constant of each ratio
keeps its start value, and the others are stated for this value, with its doubt.
"""

import math
from collections.abc import Collection, Mapping

from bdt_plant.plant import PlantModel
from bdt_study.calibration.constant import GAP, HELD, Constant, held_constants
from bdt_study.calibration.finding import LARGEST_UNCERTAINTY, Finding, structure_ratios
from bdt_study.calibration.identification import Identification
from bdt_study.calibration.start_values import model_values
from bdt_twin.machine_knowledge import USUAL_STRIBECK_SPEED

TORQUE_OF_A_VOLT = ("motor.torque_constant", "motor.resistance")
"""Constants on which it depends what torque a voltage is."""
START_SPREAD = 0.35
"""Relative standard uncertainty of a start value that the data cannot tell: a factor of two is
rare."""
SAMPLE_SHARE = 0.25
"""Share of a sample time by which the delay is unsure whatever the data: they are samples."""


def machine_constants(
    start: PlantModel,
    found: Identification,
    gap: tuple[float, float],
    sample_time: float,
    known: Collection[str] = (),
) -> dict[str, Constant]:
    """Return all constants by the names that they have as parameters.

    Parameters
    ----------
    start : PlantModel
        Start values.
    found : Identification
        The machine that was found.
    gap : (float, float)
        Gap and its standard uncertainty [rad].
    sample_time : float
        Sample time [s].
    known : collection of str
        Those of ``HELD`` whose start value is right.
    """
    finding, values = Finding(start, found), model_values(start)
    values["motor.back_emf_constant"] /= finding.values["gain"]
    doubt = {name: 0.0 if name in known else START_SPREAD for name in HELD}
    constants = held_constants(values, doubt)
    motor, value, deviation = start.motor, finding.values, finding.deviations
    constants["motor.back_emf_constant"] = finding.constant(
        "gain",
        values["motor.back_emf_constant"],
        "V s/rad",
        values["motor.back_emf_constant"] * deviation["gain"],
        [
            (
                "motor.viscous_friction",
                constants["motor.viscous_friction"].standard_uncertainty
                * motor.resistance
                / motor.torque_constant,
            )
        ],
    )
    per_volt = motor.torque_constant / motor.resistance
    friction = value["friction_voltage"] * per_volt
    constants["motor.coulomb_friction"] = finding.constant(
        "friction_voltage",
        friction,
        "N m",
        deviation["friction_voltage"] * per_volt,
        [(name, friction * doubt[name]) for name in TORQUE_OF_A_VOLT],
    )
    for name, unit in (("stiffness", "N/m"), ("damping", "N s/m")):
        found_value = values[f"structure.{name}"] * value[name]
        constants[f"structure.{name}"] = finding.constant(
            name,
            found_value,
            unit,
            found_value * deviation[name],
            [("structure.mass", found_value * doubt["structure.mass"])],
        )
    lag = _motor_lag(found.found_model)
    late = math.hypot(deviation["delay"], SAMPLE_SHARE * sample_time)
    constants["sensor.delay"] = finding.constant(
        "delay",
        value["delay"],
        "s",
        late,
        [
            (name, lag * doubt[name])
            for name in ("motor.inertia", "motor.resistance", "motor.torque_constant")
        ],
    )
    constants["sensor.drift"] = finding.constant("drift", value["drift"], "m/s", deviation["drift"])
    constants["actuator.offset"] = finding.constant(
        "voltage_offset", value["voltage_offset"], "V", deviation["voltage_offset"]
    )
    finding.determined["gap"] = found.explains and gap[1] <= LARGEST_UNCERTAINTY["gap"]
    constants[GAP] = finding.constant("gap", gap[0], "rad", gap[1])
    if "excess_voltage" in found.joined:
        constants |= _friction_at_rest(finding, per_volt, doubt)
    return constants | _ratio_constants(start, found, finding, late)


def _friction_at_rest(
    finding: Finding, per_volt: float, doubt: Mapping[str, float]
) -> dict[str, Constant]:
    """Return what friction does at low speeds; the torque of a volt at rest is `per_volt`."""
    excess, value, deviation = "excess_voltage", finding.values, finding.deviations
    torque = (value["friction_voltage"] + value[excess]) * per_volt
    torque_deviation = math.hypot(deviation["friction_voltage"], deviation[excess]) * per_volt
    speed = USUAL_STRIBECK_SPEED * math.exp(value["stribeck_speed"])
    return {
        "motor.static_friction": finding.constant(
            excess,
            torque,
            "N m",
            torque_deviation,
            [(name, torque * doubt[name]) for name in TORQUE_OF_A_VOLT],
        ),
        "motor.stribeck_speed": finding.constant(
            "stribeck_speed", speed, "rad/s", speed * deviation["stribeck_speed"]
        ),
    }


def _ratio_constants(
    start: PlantModel, found: Identification, finding: Finding, late: float
) -> dict[str, Constant]:
    """Return what the data tell by themselves; these are no parameters of a node."""
    stiffness, damping = structure_ratios(start)
    value, deviation = finding.values, finding.deviations
    stiffness, damping = stiffness * value["stiffness"], damping * value["damping"]
    response = value["delay"] + _motor_lag(found.found_model)
    ratios = [
        ("friction_voltage", "friction_voltage", value["friction_voltage"], "V", 1.0),
        ("stiffness_per_mass", "stiffness", stiffness, "1/s^2", stiffness),
        ("damping_per_mass", "damping", damping, "1/s", damping),
    ]
    if "load_voltage" in found.joined:
        ratios.append(("load_voltage", "load_voltage", value["load_voltage"], "V/N", 1.0))
    constants = {
        name: finding.constant(told_by, each, unit, scale * deviation[told_by])
        for name, told_by, each, unit, scale in ratios
    }
    return constants | {"response_delay": finding.constant("delay", response, "s", late)}


def _motor_lag(model: PlantModel) -> float:
    """Return the time by which the motor answers late, R J / (k_B k_T) [s]."""
    motor = model.motor
    return motor.resistance * motor.inertia / (motor.back_emf_constant * motor.torque_constant)
