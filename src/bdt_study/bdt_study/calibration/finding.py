"""What a fit has found out, and what it leaves as it was believed to be."""

import math
from collections.abc import Sequence

import numpy as np

from bdt_plant.friction import friction_voltage
from bdt_plant.plant import PlantModel
from bdt_study.calibration.constant import Constant
from bdt_study.calibration.identification import Identification
from bdt_study.calibration.prior_knowledge import (
    CALIBRATED_EFFECTS,
    EFFECT_SPREAD,
    FACTOR_SPREAD,
)
from bdt_twin.machine_knowledge import EFFECTS
from bdt_twin.model_factors import FACTORS

WALK_DOUBT = {
    "friction_voltage": 3.0,
    "cogging_sine": 1.0,
    "cogging_cosine": 1.0,
    "voltage_offset": 0.3,
}
"""Times that voltages are off by the one that moves the motor as far as it walks in a second."""
STRUCTURE_DOUBT = {"stiffness": 3e-4, "damping": 0.01}
"""Logarithms by which the structure is off where the motor walks in a second by the noise of a
reading or more: it does so in time with the ringing, too, which then seems to decay sooner."""

LARGEST_UNCERTAINTY = {
    "gain": 0.05,
    "stiffness": 0.05,
    "damping": 0.2,
    "friction_voltage": 0.05,
    "voltage_offset": 0.01,
    "delay": 2.5e-4,
    "drift": 2e-7,
    "excess_voltage": 0.05,
    "stribeck_speed": 0.3,
    "load_voltage": 1e-3,
    "cogging_sine": 5e-3,
    "cogging_cosine": 5e-3,
    "friction_growth": 1e-3,
    "friction_slope": 5.0,
    "yield_angle": 2e-3,
    "voltage_lag": 2.5e-4,
    "top_mass": 0.02,
    "thread_sine": 2e-7,
    "thread_cosine": 2e-7,
    "gap": math.radians(1.0),
}
"""Standard uncertainties above which data have not determined something: of logarithms of the
factors, of ``EFFECTS`` in their units, and of the gap [rad]."""

MOTION_OF = {
    "gain": "motion over some millimeters at constant speed",
    "stiffness": "steps that make the structure ring",
    "damping": "steps, with rests in which the ringing dies away",
    "friction_voltage": "slow motion in both directions, at two speeds",
    "voltage_offset": "slow motion forward and backward at the same speed",
    "delay": "quick reversals, before anything has come to rest",
    "drift": "a rest at the same place at the beginning and at the end",
    "excess_voltage": "slow motion with rests, in which the motor sticks and breaks loose",
    "stribeck_speed": "slow motion at several speeds",
    "load_voltage": "steps that bend the structure while the motor drives it",
    "cogging_sine": "slow motion over some millimeters",
    "cogging_cosine": "slow motion over some millimeters",
    "friction_growth": "the same motion at the beginning and at the end",
    "friction_slope": "slow motion over more of the travel",
    "yield_angle": "quick reversals, before anything has come to rest",
    "voltage_lag": "quick reversals, before anything has come to rest",
    "top_mass": "steps that make both modes of the structure ring",
    "thread_sine": "slow motion over some turns of the screw",
    "thread_cosine": "slow motion over some turns of the screw",
    "gap": "reversals of the motor, each beyond the gap",
}
"""Motion that would tell what the data do not."""
EXPLAINED_MOTION = "a motion of which the model leaves less, to and fro for some times"
"""What would tell everything if the model does not explain the data."""


class Finding:
    """Values and uncertainties of what a fit looked for, or of the prior where it found nothing.

    Parameters
    ----------
    start : PlantModel
        Start values.
    found : Identification
        The machine that was found.

    Attributes
    ----------
    values, deviations : dict of str to float
        For each of ``FACTORS`` (as the factor itself), ``CALIBRATED_EFFECTS`` and effects that
        joined its value and its standard uncertainty, which is relative for a factor.
    determined : dict of str to bool
        Whether the data have determined it.
    """

    def __init__(self, start: PlantModel, found: Identification) -> None:
        machine = found.fit.machine
        self._explains = found.explains
        spreads = np.sqrt(np.diag(machine.covariance)).tolist()
        names = (*FACTORS, *EFFECTS)
        deviations = dict(zip(names, spreads, strict=True))
        voltage = _walk_voltage(found)
        doubts = {name: times * voltage for name, times in WALK_DOUBT.items()}
        doubt = doubts["friction_voltage"]
        # Friction that is off by a voltage makes all speeds off by its share of the voltage.
        doubts["gain"] = doubt / _usual_voltage(found)
        share = min(_walk(found) / found.fit.levels.reading, 1.0)
        doubts |= {name: share * size for name, size in STRUCTURE_DOUBT.items()}
        excess = found.effect("excess_voltage")
        if excess > 0.0:
            doubts |= {"excess_voltage": doubt, "stribeck_speed": doubt / excess}
        for name, size in doubts.items():
            deviations[name] = math.hypot(deviations[name], size)
        gain = start.motor.back_emf_constant / found.found_model.motor.back_emf_constant
        ratios = zip(structure_ratios(found.found_model), structure_ratios(start), strict=True)
        factors = (gain, *(after / before for after, before in ratios))
        values = dict(
            zip(names, (*factors, *machine.expected[len(FACTORS) :].tolist()), strict=True)
        )
        starts = dict.fromkeys(FACTORS, 1.0) | {"friction_voltage": friction_voltage(start.motor)}
        prior = dict(zip(names, (*FACTOR_SPREAD, *EFFECT_SPREAD), strict=True))
        self.values, self.deviations, self.determined = {}, {}, {}
        for name in (*FACTORS, *CALIBRATED_EFFECTS, *found.joined):
            is_found = found.explains and deviations[name] <= LARGEST_UNCERTAINTY[name]
            self.determined[name] = is_found
            self.values[name] = values[name] if is_found else starts.get(name, 0.0)
            self.deviations[name] = deviations[name] if is_found else prior[name]

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
        revealed_by = MOTION_OF[name] if self._explains else EXPLAINED_MOTION
        return Constant(
            value,
            unit,
            math.hypot(deviation, *(doubt for _, doubt in doubts)),
            determined,
            tuple(held for held, _ in doubts),
            deviation,
            "" if determined else revealed_by,
        )


def _walk_voltage(found: Identification) -> float:
    """Return the voltage that moves the motor as far in a second as it walks [V].

    A walk of the motor that the data show is what friction does that depends on speed or place. By
    how much it is off in a second, the friction may be off in all of them.
    """
    motor, pitch = found.found_model.motor, found.model.lead_screw.pitch
    return _walk(found) * motor.back_emf_constant / pitch


def _walk(found: Identification) -> float:
    """Return the walk of the motor in a second [m]."""
    return max(found.fit.levels.fast, found.fit.levels.slow)


def _usual_voltage(found: Identification) -> float:
    """Return the rms of the voltage while the motor turns [V]."""
    voltage = np.concatenate([stretch.voltage for stretch in found.window.stretches])
    turns = np.abs(voltage) > found.effect("friction_voltage")
    return float(np.sqrt(np.mean(np.square(voltage[turns])))) if turns.any() else 1.0


def structure_ratios(model: PlantModel) -> tuple[float, float]:
    """Return k/m [1/s^2] and c/m [1/s]."""
    structure = model.structure
    return structure.stiffness / structure.mass, structure.damping / structure.mass
