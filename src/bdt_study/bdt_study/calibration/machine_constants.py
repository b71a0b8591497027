"""What a fit has found out about each constant, and what it leaves as it was believed to be.

Voltage and position tell ratios only: the motor turns by the voltage less that of the friction,
over its back EMF, whatever the torques behind it; the structure follows its base by k/m and c/m;
and a motor that is slow to answer looks like a reading that is late. One constant of each ratio
keeps its start value, and the others are stated for this value, with its doubt.
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from bdt_plant.friction import friction_voltage
from bdt_plant.plant import PlantModel
from bdt_study.calibration.identification import (
    EFFECT_SPREAD,
    FACTOR_SPREAD,
    Identification,
)
from bdt_study.calibration.start_values import model_values
from bdt_twin.machine_knowledge import EFFECTS
from bdt_twin.model_factors import FACTORS

START_SPREAD = 0.35
"""Relative standard uncertainty of a start value that the data cannot tell: a factor of two is
rare."""
VISCOUS_SHARE = 0.005
"""Share of the back EMF that viscous friction which nobody has looked for may seem to be."""
SAMPLE_SHARE = 0.25
"""Share of a sample time by which the delay is unsure whatever the data: they are samples."""

FRICTION_DOUBT = 3.0
"""Times that the friction is off by more than the walk of the motor in a second tells."""

HELD = (
    "motor.torque_constant",
    "motor.resistance",
    "motor.inertia",
    "motor.inductance",
    "motor.viscous_friction",
    "structure.mass",
)
"""Constants that voltage and position cannot tell."""

LARGEST_UNCERTAINTY = {
    "gain": 0.05,
    "stiffness": 0.05,
    "damping": 0.2,
    "friction_voltage": 0.05,
    "voltage_offset": 0.01,
    "delay": 2.5e-4,
    "drift": 2e-7,
    "gap": math.radians(1.0),
}
"""Standard uncertainties above which data have not determined something: of logarithms of the
factors, and of effects [V, V, s, m/s] and gap [rad]."""

MOTION_OF = {
    "gain": "motion over some millimeters at constant speed",
    "stiffness": "steps that make the structure ring",
    "damping": "steps, with rests in which the ringing dies away",
    "friction_voltage": "slow motion in both directions, at two speeds",
    "voltage_offset": "slow motion forward and backward at the same speed",
    "delay": "quick reversals, before anything has come to rest",
    "drift": "a rest at the same place at the beginning and at the end",
    "gap": "reversals of the motor, each beyond the gap",
}
"""Motion that would tell what the data do not."""

_BY_OTHER_MEANS = {
    "motor.torque_constant": "a measured current, or a known torque",
    "motor.resistance": "voltage and current of the motor at rest",
    "motor.inertia": "a known torque, or the data sheet of the motor",
    "motor.inductance": "voltage and current of the motor at rest",
    "motor.viscous_friction": "a measured current at two speeds",
    "structure.mass": "a pair of scales",
}


@dataclass(frozen=True)
class Constant:
    """A constant of the machine after a calibration.

    Attributes
    ----------
    value : float
        Its value.
    unit : str
        Unit of the value.
    standard_uncertainty : float
        Standard uncertainty, the doubt about what it is stated for included.
    determined : bool
        Whether the data tell it; otherwise it has its start value.
    given : tuple of str
        Constants that the data do not tell, for whose start values it is stated.
    standard_uncertainty_given : float
        Standard uncertainty if these were known exactly.
    revealed_by : str
        What would tell a constant that is not determined; "" for one that is.
    """

    value: float
    unit: str
    standard_uncertainty: float
    determined: bool
    given: tuple[str, ...] = ()
    standard_uncertainty_given: float = 0.0
    revealed_by: str = ""


class _Finding:
    """Values and uncertainties of what a fit looked for, or of the prior where it found nothing."""

    def __init__(self, start: PlantModel, found: Identification) -> None:
        machine = found.fit.machine
        names = (*FACTORS, *EFFECTS)
        deviations = np.sqrt(np.diag(machine.covariance)).tolist()
        friction = len(FACTORS) + EFFECTS.index("friction_voltage")
        doubt = _friction_doubt(found)
        deviations[friction] = math.hypot(deviations[friction], doubt)
        # Friction that is off by a voltage makes all speeds off by its share of the voltage.
        deviations[0] = math.hypot(deviations[0], doubt / _usual_voltage(found))
        gain = start.motor.back_emf_constant / found.found_model.motor.back_emf_constant
        ratios = [_ratios(found.found_model), _ratios(start)]
        factors = (
            gain,
            *(after / before for after, before in zip(*ratios, strict=True)),
        )
        values = [*factors, *machine.expected[len(FACTORS) :].tolist()]
        starts = [1.0] * len(FACTORS) + [friction_voltage(start.motor), 0.0, 0.0, 0.0]
        spreads = (*FACTOR_SPREAD, *EFFECT_SPREAD)
        self.values, self.deviations = {}, {}
        self.determined = {
            name: deviation <= LARGEST_UNCERTAINTY[name]
            for name, deviation in zip(names, deviations, strict=True)
        }
        for name, value, deviation, first, spread in zip(
            names, values, deviations, starts, spreads, strict=True
        ):
            is_found = self.determined[name]
            self.values[name] = value if is_found else first
            self.deviations[name] = deviation if is_found else spread

    def constant(
        self,
        name: str,
        value: float,
        unit: str,
        deviation: float,
        doubts: Sequence[tuple[str, float]] = (),
    ) -> Constant:
        """Return a constant that stands on a finding.

        Parameters
        ----------
        name : str
            The finding.
        value, unit
            See :class:`Constant`.
        deviation : float
            Standard uncertainty from the finding.
        doubts : sequence of (str, float)
            Constants for which it is stated, with the standard uncertainty that comes from each.
        """
        determined = self.determined[name]
        return Constant(
            value,
            unit,
            math.hypot(deviation, *(doubt for _, doubt in doubts)),
            determined,
            tuple(held for held, _ in doubts),
            deviation,
            "" if determined else MOTION_OF[name],
        )


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
    finding, values = _Finding(start, found), model_values(start)
    values["motor.back_emf_constant"] /= finding.values["gain"]
    doubt = {name: 0.0 if name in known else START_SPREAD for name in HELD}
    constants = _held_constants(values, doubt)
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
        [(name, friction * doubt[name]) for name in ("motor.torque_constant", "motor.resistance")],
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
    finding.determined["gap"] = gap[1] <= LARGEST_UNCERTAINTY["gap"]
    constants["gap.initial"] = finding.constant("gap", gap[0], "rad", gap[1])
    return constants | _ratio_constants(start, found, finding, late)


def _ratio_constants(
    start: PlantModel, found: Identification, finding: _Finding, late: float
) -> dict[str, Constant]:
    """Return what the data tell by themselves; these are no parameters of a node."""
    stiffness, damping = _ratios(start)
    value, deviation = finding.values, finding.deviations
    stiffness, damping = stiffness * value["stiffness"], damping * value["damping"]
    response = value["delay"] + _motor_lag(found.found_model)
    return {
        "friction_voltage": finding.constant(
            "friction_voltage", value["friction_voltage"], "V", deviation["friction_voltage"]
        ),
        "stiffness_per_mass": finding.constant(
            "stiffness", stiffness, "1/s^2", stiffness * deviation["stiffness"]
        ),
        "damping_per_mass": finding.constant(
            "damping", damping, "1/s", damping * deviation["damping"]
        ),
        "response_delay": finding.constant("delay", response, "s", late),
    }


def _held_constants(values: dict[str, float], doubt: dict[str, float]) -> dict[str, Constant]:
    """Return the constants that keep their start values."""
    units = {
        "motor.torque_constant": "N m/A",
        "motor.resistance": "Ohm",
        "motor.inertia": "kg m^2",
        "motor.inductance": "H",
        "motor.viscous_friction": "N m s/rad",
        "structure.mass": "kg",
    }
    held = {}
    for name in HELD:
        spread = values[name] * doubt[name]
        if name == "motor.viscous_friction" and doubt[name]:
            back_emf = values["motor.back_emf_constant"] * values["motor.torque_constant"]
            spread = max(spread, VISCOUS_SHARE * back_emf / values["motor.resistance"])
        held[name] = Constant(
            values[name],
            units[name],
            spread,
            determined=False,
            standard_uncertainty_given=spread,
            revealed_by=_BY_OTHER_MEANS[name],
        )
    return held


def _friction_doubt(found: Identification) -> float:
    """Return by how much the friction's voltage is unsure because it is not the same always [V].

    A walk of the motor that the data show is what friction does that depends on speed or place. By
    how much it is off in a second, the friction may be off in all of them.
    """
    motor, pitch = found.found_model.motor, found.model.lead_screw.pitch
    walk = max(found.fit.levels.fast, found.fit.levels.slow)
    return FRICTION_DOUBT * walk * motor.back_emf_constant / pitch


def _usual_voltage(found: Identification) -> float:
    """Return the rms of the voltage while the motor turns [V]."""
    voltage = np.concatenate([stretch.voltage for stretch in found.window.stretches])
    turns = np.abs(voltage) > found.effect("friction_voltage")
    return float(np.sqrt(np.mean(np.square(voltage[turns])))) if turns.any() else 1.0


def _motor_lag(model: PlantModel) -> float:
    """Return the time by which the motor answers late, R J / (k_B k_T) [s]."""
    motor = model.motor
    return motor.resistance * motor.inertia / (motor.back_emf_constant * motor.torque_constant)


def _ratios(model: PlantModel) -> tuple[float, float]:
    """Return k/m [1/s^2] and c/m [1/s]."""
    structure = model.structure
    return structure.stiffness / structure.mass, structure.damping / structure.mass
