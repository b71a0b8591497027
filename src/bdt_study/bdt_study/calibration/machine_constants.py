"""All constants of a machine from what a fit has found out.

Voltage and position tell ratios only: the motor turns by the voltage less that of the friction,
over its back EMF, whatever the torques behind it; the structure follows its base by k/m and c/m;
and a motor that is slow to answer looks like a reading that is late. One constant of each ratio
keeps its start value, and the others are stated for this value, with its doubt.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from bdt_plant.plant import PlantModel
from bdt_study.calibration.constant import GAP, HELD, Constant, held_constants
from bdt_study.calibration.finding import LARGEST_UNCERTAINTY, Finding, structure_ratios
from bdt_study.calibration.identification import Identification
from bdt_study.calibration.motor_lag import SMALLEST_LAG, motor_lag, with_lag
from bdt_study.calibration.start_values import model_values
from bdt_twin.machine_knowledge import COGGING_PARTS, THREAD_PARTS, USUAL_STRIBECK_SPEED

TORQUE_OF_A_VOLT = ("motor.torque_constant", "motor.resistance")
"""Constants on which it depends what torque a voltage is."""
START_SPREAD = 0.35
"""Relative standard uncertainty of a start value that the data cannot tell: a factor of two is
rare."""
RATIOS = (
    ("load_voltage", "V/N"),
    ("friction_growth", "1/s"),
    ("friction_slope", "1/m"),
    ("yield_angle", "rad"),
)
"""Effects that the data tell by themselves where the machine has them, and their units."""
COVERAGE = 2.0
"""Standard uncertainties by which a reading is early before the start value of the inertia is."""
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
    late = math.hypot(finding.deviations["delay"], SAMPLE_SHARE * sample_time)
    response = lag = _lag_of_start(start, found)
    if finding.determined["delay"]:
        response = finding.values["delay"] + motor_lag(found.found_model)
    if response < lag - COVERAGE * late and "motor.inertia" not in known:
        lag = max(response, SMALLEST_LAG)
        values["motor.inertia"] = with_lag(found.found_model, lag).motor.inertia
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
    friction = "friction_voltage"
    constants["motor.coulomb_friction"] = _torque(
        finding, friction, value[friction] * per_volt, deviation[friction] * per_volt, doubt
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
    constants["sensor.delay"] = finding.constant(
        "delay",
        response - lag,
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
    if "top_mass" in found.joined:
        ratio = values["structure.top_mass_ratio"] * math.exp(value["top_mass"])
        constants["structure.top_mass_ratio"] = finding.constant(
            "top_mass", ratio, "", ratio * deviation["top_mass"]
        )
    if COGGING_PARTS[0] in found.joined:
        constants |= _cogging(finding, found.window.cogs, per_volt, doubt)
    if "voltage_lag" in found.joined:
        constants["actuator.lag"] = finding.constant(
            "voltage_lag", value["voltage_lag"], "s", deviation["voltage_lag"]
        )
    if THREAD_PARTS[0] in found.joined:
        constants["lead_screw.thread_error"] = _thread_error(finding)
    return constants | _ratio_constants(start, found, finding, (response, late))


def _lag_of_start(start: PlantModel, found: Identification) -> float:
    """Return how late the motor that was found answers with the start value of the inertia [s]."""
    motor = replace(found.found_model.motor, inertia=start.motor.inertia)
    return motor_lag(replace(found.found_model, motor=motor))


def _torque(
    finding: Finding, name: str, torque: float, deviation: float, doubt: Mapping[str, float]
) -> Constant:
    """Return a torque that a voltage tells [N m], for what a volt of it is."""
    given = [(held, torque * doubt[held]) for held in TORQUE_OF_A_VOLT]
    return finding.constant(name, torque, "N m", deviation, given)


def _friction_at_rest(
    finding: Finding, per_volt: float, doubt: Mapping[str, float]
) -> dict[str, Constant]:
    """Return what friction does at low speeds; the torque of a volt at rest is `per_volt`."""
    excess, value, deviation = "excess_voltage", finding.values, finding.deviations
    torque = (value["friction_voltage"] + value[excess]) * per_volt
    torque_deviation = math.hypot(deviation["friction_voltage"], deviation[excess]) * per_volt
    speed = USUAL_STRIBECK_SPEED * math.exp(value["stribeck_speed"])
    return {
        "motor.static_friction": _torque(finding, excess, torque, torque_deviation, doubt),
        "motor.stribeck_speed": finding.constant(
            "stribeck_speed", speed, "rad/s", speed * deviation["stribeck_speed"]
        ),
    }


def _cogging(
    finding: Finding, cogs: int, per_volt: float, doubt: Mapping[str, float]
) -> dict[str, Constant]:
    """Return amplitude and number of periods of the cogging; its phase is that of the position."""
    spreads = [finding.deviations[name] * per_volt for name in COGGING_PARTS]
    for name in COGGING_PARTS:
        if not finding.determined[name]:
            return {"motor.cogging_torque": _torque(finding, name, 0.0, max(spreads), doubt)}
    torque, own = (per_volt * size for size in _amplitude(finding, COGGING_PARTS))
    return {
        "motor.cogging_torque": _torque(finding, COGGING_PARTS[0], torque, own, doubt),
        "motor.cogging_periods": finding.constant(COGGING_PARTS[0], cogs, "", 0.0),
    }


def _thread_error(finding: Finding) -> Constant:
    """Return the amplitude of the error of the screw's thread [m]."""
    for name in THREAD_PARTS:
        if not finding.determined[name]:
            return finding.constant(name, 0.0, "m", finding.deviations[name])
    size, own = _amplitude(finding, THREAD_PARTS)
    return finding.constant(THREAD_PARTS[0], size, "m", own)


def _amplitude(finding: Finding, parts: Sequence[str]) -> tuple[float, float]:
    """Return the amplitude of a wave of two parts, and its standard uncertainty."""
    sizes = [finding.values[name] for name in parts]
    amplitude = math.hypot(*sizes)
    weighted = [size * finding.deviations[name] for size, name in zip(sizes, parts, strict=True)]
    return amplitude, math.hypot(*weighted) / amplitude


def _ratio_constants(
    start: PlantModel, found: Identification, finding: Finding, response: tuple[float, float]
) -> dict[str, Constant]:
    """Return what the data tell by themselves; these are no parameters of a node."""
    stiffness, damping = structure_ratios(start)
    value, deviation = finding.values, finding.deviations
    stiffness, damping = stiffness * value["stiffness"], damping * value["damping"]
    ratios = [
        ("friction_voltage", "friction_voltage", value["friction_voltage"], "V", 1.0),
        ("stiffness_per_mass", "stiffness", stiffness, "1/s^2", stiffness),
        ("damping_per_mass", "damping", damping, "1/s", damping),
    ]
    ratios += [
        (name, name, value[name], unit, 1.0) for name, unit in RATIOS if name in found.joined
    ]
    constants = {
        name: finding.constant(told_by, each, unit, scale * deviation[told_by])
        for name, told_by, each, unit, scale in ratios
    }
    delay, late = response
    return constants | {"response_delay": finding.constant("delay", delay, "s", late)}
