"""The mechanism that an emulated device drives: a plant as a configuration describes it."""

from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_files import PARAMETERS_KEY, checked_parameters, is_for, read_sections
from bdt_msgs_py.parameter_tables import in_parameter_names, parameter_sets
from bdt_msgs_py.topics import PLANT_NODE
from bdt_plant.actuator import ActuatorParameters
from bdt_plant.compiled_period import compiled_period_of
from bdt_plant.gap_profile import GapProfile
from bdt_plant.parameters import PARAMETERS
from bdt_plant.plant import PlantModel, Sampling
from bdt_plant.plant_simulator import PlantSimulator
from bdt_plant.sensor import SensorParameters


class Mechanism(NamedTuple):
    """Constants of motor, screw, structure, amplifier and sensor, and the growth of the gap."""

    model: PlantModel
    profile: GapProfile
    sampling: Sampling
    actuator: ActuatorParameters
    sensor: SensorParameters

    def simulator(self) -> PlantSimulator:
        """Return the mechanism at rest, with the gap as it is when it is new."""
        model, profile, sampling, actuator, sensor = self
        period = compiled_period_of(model)
        return PlantSimulator(model, profile, sampling, sensor, actuator, period)


def load_mechanism(path: Path | None, frame_rate: float) -> Mechanism:
    """Return the mechanism that the section of the plant in a configuration describes.

    Parameters
    ----------
    path : Path or None
        ROS parameter file; None for the paper's mechanism.
    frame_rate : float
        Rate at which its samples are handed on, and voltages come into force [Hz].

    Raises
    ------
    BadInputError
        With one line that names the file, the key, the value and what is allowed.
    """
    values: dict[str, Any] = {}
    for section, content in read_sections(f"--config {path}", path).items() if path else ():
        if not is_for(section, f"/{PLANT_NODE}"):
            continue
        if not isinstance(content, dict) or set(content) != {PARAMETERS_KEY}:
            raise BadInputError(f"{path}: {section}: must hold the key {PARAMETERS_KEY}, only")
        label, for_all = f"{path}: {section}", section.endswith("*")
        values |= checked_parameters(
            label, content[PARAMETERS_KEY] or {}, PARAMETERS, for_all=for_all
        )
    if path and not values:
        raise BadInputError(f"{path}: holds nothing for /{PLANT_NODE}: there is no mechanism")
    try:
        sets = parameter_sets(PARAMETERS, values)
        _, sampling, *constants, profile, actuator, sensor, _ = sets
        sampling = replace(sampling, control_rate=frame_rate)
    except ValueError as error:
        text = in_parameter_names(str(error), PARAMETERS)
        raise BadInputError(f"{path or 'emulator'}: {text}") from error
    return Mechanism(PlantModel(*constants), profile, sampling, actuator, sensor)
