"""Which estimator looks at a recording again, and with which settings: ``--estimator``, ``--set``.

Every setting is the one of the command line, else the one that the twin had (its parameter events
are in the bag), else the default. The sampling rate is that of the recording unless it is set.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import yaml

from bdt_bags.reading.recording import Recording
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_tables import (
    check_value,
    full_name,
    in_parameter_names,
    known_parameters,
    parameter_sets,
    suggestion,
)
from bdt_msgs_py.telemetry_sequence import LONGEST_BUNCH
from bdt_plant.lead_screw import LeadScrewParameters
from bdt_plant.motor import MotorParameters
from bdt_plant.plant import PlantModel
from bdt_plant.structure import StructureParameters
from bdt_twin.estimator import Estimator
from bdt_twin.estimator_choice import EstimatorChoice, create_estimator
from bdt_twin.inverse_filter import InverseFilterSettings
from bdt_twin.output_error_settings import OutputErrorSettings
from bdt_twin.parameters import PARAMETERS

KIND, SAMPLING_RATE = "estimator.kind", "estimator.sampling_rate"

MODEL = (MotorParameters, LeadScrewParameters, StructureParameters)
"""Parameters of the mechanism, which every estimator gets."""

SETTINGS_OF = {"inverse_filter": InverseFilterSettings, "output_error": OutputErrorSettings}
"""Settings that an estimator has for itself; one from elsewhere has none."""

CLOCK_ERROR = 2e-3
"""Relative error of a machine's clock."""
WHOLE_RATE = 1e-6
"""Relative difference up to which a sampling rate is a whole number of hertz: stamps of a clock
that counts from 1970 resolve no more."""


@dataclass(frozen=True)
class EstimatorSetup:
    """An estimator with all that it needs.

    Attributes
    ----------
    kind : str
        As in the twin's parameter ``estimator.kind``.
    model : PlantModel
        Constants of the mechanism, as the twin is to know them.
    inverse_filter, output_error
        Settings of the estimators.
    given : mapping of str
        What the command line sets, by the name of the twin's parameter.
    recorded : mapping of str
        What of the twin's parameters in the bag matters and is not the default.
    """

    kind: str
    model: PlantModel
    inverse_filter: InverseFilterSettings
    output_error: OutputErrorSettings
    given: Mapping[str, Any]
    recorded: Mapping[str, Any]

    @property
    def sampling_rate(self) -> float:
        """Sampling rate of the telemetry [Hz]."""
        return self.inverse_filter.sampling_rate

    @property
    def without_effect(self) -> tuple[str, ...]:
        """Names of the settings of the command line that this estimator does not look at."""
        used = _used_by(self.kind)
        return tuple(name for name in self.given if name not in used)

    def create(self) -> Estimator:
        """Return the estimator, fresh.

        Raises
        ------
        BadInputError
            If there is none of this kind or it refuses its settings.
        """
        try:
            return create_estimator(
                EstimatorChoice(self.kind), self.model, self.inverse_filter, self.output_error
            )
        except ValueError as error:
            raise BadInputError(_in_parameter_names(error)) from error


def given_settings(estimator: str | None, assignments: Sequence[str]) -> dict[str, Any] | None:
    """Return what the command line sets, by the name of the twin's parameter.

    Parameters
    ----------
    estimator : str or None
        Value of ``--estimator``; the same as ``--set estimator.kind=...``.
    assignments : sequence of str
        Values of ``--set``: ``output_error.window=10.0``, as ``ros2 param`` shows name and value.
        Of several for one name the last one holds.

    Returns
    -------
    dict or None
        None when nothing was given, so that nothing is to be estimated again.

    Raises
    ------
    BadInputError
        With one line that names the parameter, the value and what is allowed.
    """
    known = known_parameters(PARAMETERS)
    given: dict[str, Any] = {} if estimator is None else {KIND: estimator}
    for assignment in assignments:
        name, equals, text = assignment.partition("=")
        name = name.strip()
        if not equals:
            raise BadInputError(f"--set {assignment!r}: must be KEY=VALUE")
        if name not in known:
            raise BadInputError(
                f"--set {name} = {text.strip()!r}: is not a parameter of the twin"
                f"{suggestion(name, known)}"
            )
        if name == KIND and estimator is not None:
            raise BadInputError(
                f"--set {name} = {text.strip()!r}: must not stand beside --estimator"
            )
        given[name] = _parsed(text.strip(), known[name][0])
        check_value(f"--set {name}", given[name], *known[name])
    if KIND in given:
        try:
            EstimatorChoice(given[KIND])
        except ValueError as error:
            option = f"--set {KIND}" if estimator is None else "--estimator"
            raise BadInputError(str(error).replace("EstimatorChoice.kind", option)) from error
    return given or None


def estimator_setup(recording: Recording, given: Mapping[str, Any]) -> EstimatorSetup:
    """Return the estimator for a recording.

    Parameters
    ----------
    recording : Recording
        The run; tells the sampling rate and what the twin's parameters were.
    given : mapping of str
        From :func:`given_settings`.

    Raises
    ------
    BadInputError
        If a value of the bag is not allowed or values do not go together.
    """
    known, told = known_parameters(PARAMETERS), recording.twin_parameters
    kind = given.get(KIND, told.get(KIND, known[KIND][0]))
    recorded = {
        name: told[name]
        for name in known
        if name in told and name in _used_by(kind) and name not in (SAMPLING_RATE, *given)
    }
    recorded = {name: value for name, value in recorded.items() if value != known[name][0]}
    for name, value in recorded.items():
        check_value(f"bag {recording.path}: parameter {name} of the twin", value, *known[name])
    values = {SAMPLING_RATE: _whole_rate(recording), **recorded, **given}
    try:
        sets = parameter_sets(PARAMETERS, values)
    except ValueError as error:
        raise BadInputError(_in_parameter_names(error)) from error
    by_kind = {type(each): each for each in sets}
    return EstimatorSetup(
        kind=by_kind[EstimatorChoice].kind,
        model=PlantModel(*(by_kind[kind] for kind in MODEL)),
        inverse_filter=by_kind[InverseFilterSettings],
        output_error=by_kind[OutputErrorSettings],
        given=given,
        recorded=recorded,
    )


def sampling_rate(recording: Recording) -> float:
    """Return the sampling rate of the telemetry [Hz], the mean where there is no hole."""
    steps = np.diff(recording.telemetry[:, 0])
    middle = float(np.median(steps))
    within_bunches = float(np.mean(steps[steps <= max(middle, LONGEST_BUNCH)]))
    is_bunched = middle < 0.5 * within_bunches
    usual = steps[np.abs(steps - middle) < 0.5 * middle]
    rate = 1.0 / (within_bunches if is_bunched else float(np.mean(usual)))
    whole = float(round(rate))
    return whole if abs(rate - whole) <= WHOLE_RATE * rate else rate


def _whole_rate(recording: Recording) -> float:
    """Return the sampling rate as a whole number of hertz, if it is one but for a clock's error.

    What is a whole number of samples by the rate that was meant is so by this one.
    """
    rate = sampling_rate(recording)
    rounded = (unit * round(rate / unit) for unit in (100.0, 50.0, 10.0, 1.0))
    return next((each for each in rounded if abs(each - rate) <= CLOCK_ERROR * rate), rate)


def _used_by(kind: Any) -> set[str]:
    """Return the names of the twin's parameters that matter to a kind of estimator."""
    sets = (*MODEL, SETTINGS_OF.get(kind))
    return {KIND, SAMPLING_RATE} | {
        full_name(prefix, field.name)
        for prefix, parameters in PARAMETERS
        if parameters in sets
        for field in fields(parameters)
    }


def _parsed(text: str, default: Any) -> Any:
    """Return a value as a parameter file would give it; a text needs no quotes."""
    if isinstance(default, str):
        return text
    try:
        value = yaml.safe_load(text)
    except yaml.YAMLError:
        return text
    # YAML 1.1 takes 1e-3 for a text, for want of a point.
    if isinstance(default, float) and isinstance(value, str):
        try:
            return float(value)
        except ValueError:
            return value
    return value


def _in_parameter_names(error: ValueError) -> str:
    """Return a message of a parameter dataclass with the name that the parameter has in ROS."""
    return f"re-estimation: {in_parameter_names(str(error), PARAMETERS)}"
