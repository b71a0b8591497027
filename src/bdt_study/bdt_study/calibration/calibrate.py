"""From a bag to the constants of the machine in it: load, fit, validate, write."""

from collections.abc import Collection
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bdt_bags.reading.recording import Recording, load_recording
from bdt_bags.reading.topic_selection import TopicSelection
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_tables import suggestion
from bdt_plant.plant import PlantModel
from bdt_study.calibration.calibration_data import calibration_data, halves
from bdt_study.calibration.constant import HELD, Constant
from bdt_study.calibration.fitted_data import Data
from bdt_study.calibration.identification import Identification, identify
from bdt_study.calibration.machine_constants import machine_constants
from bdt_study.calibration.start_values import Configuration, start_model
from bdt_study.calibration.validation import Residual, residual_of, validate_machine
from bdt_twin.model_factors import check_room
from bdt_twin.unexplained_window import MISFIT

IS_IT = ": is this voltage and position of one mechanism?"


@dataclass(frozen=True, eq=False)
class Calibration:
    """A machine, and how well it is known.

    Attributes
    ----------
    start : PlantModel
        Start values.
    data : Data
        Telemetry that was looked at.
    found : Identification
        The fit.
    constants : dict
        Constants by name.
    gap, gap_uncertainty : float
        Gap and its standard uncertainty [rad] at `gap_time`.
    gap_time : float
        Time of the last reversal of the screw [s].
    residual, validation : Residual
        What the fit leaves of the data, and what the fit of the first half leaves of the second.
    """

    start: PlantModel
    data: Data
    found: Identification
    constants: dict[str, Constant]
    gap: float
    gap_uncertainty: float
    gap_time: float
    residual: Residual
    validation: Residual

    @property
    def unexplained(self) -> str:
        """What the model does not explain, in words; "" where it explains the data."""
        if self.found.explains:
            return ""
        rest, motion = self.found.fit.residual, self.found.window.motion
        return (
            f"the model does not explain {1e6 * rest:.3g} um of a motion of {1e6 * motion:.3g} um: "
            "its constants mean nothing"
        )

    def to_dictionary(self) -> dict[str, Any]:
        """Return the result for JSON."""
        return {
            "parameters": {name: asdict(each) for name, each in self.constants.items()},
            "residual_rms_m": self.residual.rms,
            "validation_rms_m": self.validation.rms,
            "delay_s": self.constants["sensor.delay"].value,
            "gap_rad": self.gap,
            "gap_standard_uncertainty_rad": self.gap_uncertainty,
            "gap_time_s": self.gap_time,
            "unexplained": self.unexplained,
        }


def calibrate(
    bag: Path,
    configuration: Configuration | None = None,
    *,
    seconds: float = 60.0,
    selection: TopicSelection | None = None,
    run: int | None = None,
    known: Collection[str] = (),
) -> Calibration:
    """Find the constants of the machine in a bag.

    Parameters
    ----------
    bag : Path
        A rosbag2 folder or a bare file.
    configuration : Configuration, optional
        Start values; without them those count that the bag tells of its twin.
    seconds : float
        Longest telemetry that is looked at [s].
    selection : TopicSelection, optional
        Which loop and which topics are meant where the bag does not tell.
    run : int, optional
        Which run is meant, from 1, of a bag that holds several.
    known : collection of str
        Constants that the data cannot tell and whose start value is right.

    Raises
    ------
    BagError
        For everything that is wrong with the bag.
    BadInputError
        If a start value is not allowed, or the telemetry does not show what the machine is like.
    """
    for name in known:
        if name not in HELD:
            raise BadInputError(
                f"--known {name}: must be one of {', '.join(HELD)}{suggestion(name, HELD)}"
            )
    return calibrate_recording(
        load_recording(bag, selection, run), configuration, seconds=seconds, known=known
    )


def calibrate_recording(
    recording: Recording,
    configuration: Configuration | None = None,
    *,
    seconds: float = 60.0,
    known: Collection[str] = (),
) -> Calibration:
    """Find the constants of the machine in a recording; see :func:`calibrate`."""
    start = start_model(configuration, recording.twin_parameters)
    try:
        check_room(start)
    except ValueError as error:
        raise BadInputError(f"start values: {error}") from error
    data = calibration_data(recording, seconds, start.lead_screw.pitch)
    try:
        found = identify(start, data)
    except ValueError as error:
        raise BadInputError(f"bag {recording.path}: {error}{IS_IT}") from error
    residual = residual_of(data, found)
    motion = float(np.std(residual.position))
    unexplained = found.fit.prediction_error
    if not unexplained <= MISFIT * motion:
        raise BadInputError(
            f"bag {recording.path}: the model does not explain {1e6 * unexplained:.3g} um "
            f"of a motion of {1e6 * motion:.3g} um{IS_IT}"
        )
    reversals = found.window.reversals(found.fit.responses)
    last = data.stretches[-1]
    end = (last.first + last.voltage.size - 1) / data.sampling_rate
    at = reversals[-1] if reversals else end
    gap, gap_uncertainty = found.gap_at(at)
    return Calibration(
        start,
        data,
        found,
        machine_constants(start, found, (gap, gap_uncertainty), 1.0 / data.sampling_rate, known),
        gap,
        gap_uncertainty,
        at,
        residual,
        validate_machine(found, *halves(data)),
    )
