"""How far a mechanism may be from what it is believed to be: ranges by hand or of a calibration."""

import itertools
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.quantities import quantity, validate
from bdt_plant.plant import PlantModel

COVERAGE = 2.0
"""Standard uncertainties of a calibration that a range covers to either side."""

CALIBRATED = {
    "back_emf": "motor.back_emf_constant",
    "stiffness": "stiffness_per_mass",
    "damping": "damping_per_mass",
}
"""Ranges that a calibration tells, and the constants whose uncertainty they are: the structure
follows its base by k/m and c/m, so that a calibration leaves the mass no range of its own."""


@dataclass(frozen=True)
class MechanismRanges:
    """Largest deviations of either sign; the defaults are those of the case ``harsh``."""

    back_emf: float = quantity(0.05, "", "of the back-EMF constant k_B", minimum=0.0, maximum=0.9)
    mass: float = quantity(0.02, "", "of the masses m", minimum=0.0, maximum=0.9)
    stiffness: float = quantity(0.02, "", "of the stiffnesses k", minimum=0.0, maximum=0.9)
    damping: float = quantity(0.2, "", "of the dampings c", minimum=0.0, maximum=0.9)

    def __post_init__(self) -> None:
        validate(self)


def corners(nominal: PlantModel, ranges: MechanismRanges) -> tuple[PlantModel, ...]:
    """Return the mechanism as it is believed to be, and all with each deviation at its largest.

    Parameters
    ----------
    nominal : PlantModel
        The mechanism as it is believed to be; the first of those returned.
    ranges : MechanismRanges
        Largest deviations.
    """
    motor, structure = nominal.motor, nominal.structure
    signs = [(1.0, -1.0) if spread else (0.0,) for spread in vars(ranges).values()]
    found = {nominal: None}
    for back_emf, mass, stiffness, damping in itertools.product(*signs):
        found[
            replace(
                nominal,
                motor=replace(
                    motor,
                    back_emf_constant=motor.back_emf_constant * (1.0 + back_emf * ranges.back_emf),
                ),
                structure=replace(
                    structure,
                    mass=structure.mass * (1.0 + mass * ranges.mass),
                    stiffness=structure.stiffness * (1.0 + stiffness * ranges.stiffness),
                    damping=structure.damping * (1.0 + damping * ranges.damping),
                ),
            )
        ] = None
    return tuple(found)


def read_ranges(path: Path) -> MechanismRanges:
    """Return the ranges that a calibration tells, two standard uncertainties to either side.

    Parameters
    ----------
    path : Path
        What ``bdt calibrate --json`` has printed.

    Raises
    ------
    BadInputError
        If it cannot be read, or does not tell them.
    """
    label = f"--calibration {path}"
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise BadInputError(f"{label}: cannot be read: {error}") from error
    except ValueError as error:
        raise BadInputError(f"{label}: is not JSON: {error}") from error
    constants = document.get("parameters") if isinstance(document, dict) else None
    if not isinstance(constants, dict):
        raise BadInputError(f"{label}: must be what bdt calibrate --json prints")
    told = {field: _range(label, constants, name) for field, name in CALIBRATED.items()}
    try:
        return MechanismRanges(mass=0.0, **told)
    except ValueError as error:
        raise BadInputError(f"{label}: is too unsure to design for: {error}") from error


def _range(label: str, constants: Mapping[str, Any], name: str) -> float:
    """Return the relative range of a constant of a calibration."""
    entry: Any = constants.get(name)
    try:
        value, doubt = float(entry["value"]), float(entry["standard_uncertainty"])
    except (KeyError, TypeError, ValueError) as error:
        raise BadInputError(f"{label}: tells no {name} with its standard_uncertainty") from error
    if not (math.isfinite(value) and math.isfinite(doubt) and value > 0.0 and doubt >= 0.0):
        raise BadInputError(f"{label}: {name} = {value:g} ± {doubt:g}: must be positive and known")
    return COVERAGE * doubt / value
