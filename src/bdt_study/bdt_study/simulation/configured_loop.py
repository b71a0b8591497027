"""A loop offline as the parameters of the nodes describe it: plant, controller and twin."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

from bdt_controller.controller import ControllerSettings
from bdt_controller.notch import NotchFilter
from bdt_controller.parameters import PARAMETERS as CONTROLLER_PARAMETERS
from bdt_controller.pid import PidGains
from bdt_controller.reference import ReferenceProfile
from bdt_msgs_py.parameter_tables import (
    ParameterTable,
    full_name,
    in_parameter_names,
    parameter_sets,
)
from bdt_msgs_py.topics import CONTROLLER_NODE, PLANT_NODE, TWIN_NODE
from bdt_plant.actuator import ActuatorParameters
from bdt_plant.gap_profile import GapProfile
from bdt_plant.parameters import MECHANISM
from bdt_plant.parameters import PARAMETERS as PLANT_PARAMETERS
from bdt_plant.plant import PlantModel, Sampling
from bdt_plant.plant_settings import PlantSettings
from bdt_plant.sensor import SensorParameters
from bdt_study.simulation.closed_loop import Scenario
from bdt_study.simulation.twin_loop import TwinTrajectory, simulate_with_twin
from bdt_twin.dead_zone_tolerance import DeadZoneSettings
from bdt_twin.decision import ControllerGains
from bdt_twin.decision_settings import DecisionSettings
from bdt_twin.estimator_choice import EstimatorChoice, create_estimator
from bdt_twin.inverse_filter import InverseFilterSettings
from bdt_twin.link import LinkSettings
from bdt_twin.output_error_settings import OutputErrorSettings
from bdt_twin.parameters import PARAMETERS as TWIN_PARAMETERS
from bdt_twin.twin_settings import TwinSettings

TABLES: Mapping[str, ParameterTable] = {
    PLANT_NODE: PLANT_PARAMETERS,
    CONTROLLER_NODE: CONTROLLER_PARAMETERS,
    TWIN_NODE: TWIN_PARAMETERS,
}
"""Parameters of the nodes of a simulated loop."""

Part = tuple[str, str, type[Any]]
"""Node, prefix and dataclass of some of its parameters."""

BELIEVED = MECHANISM[:3]
"""Parts of the mechanism that the twin has, too."""


@dataclass(frozen=True)
class TwinSetup:
    """The twin of a loop.

    Attributes
    ----------
    estimator : EstimatorChoice
        Which estimator.
    inverse_filter : InverseFilterSettings
        Settings of the paper's.
    output_error : OutputErrorSettings
        Settings of the one that fits the model.
    believed : PlantModel
        The mechanism as the twin knows it.
    link : LinkSettings
        Delays and losses on the way to the controller.
    dead_zone : DeadZoneSettings
        Width for an estimate.
    telemetry_period : float
        Time covered by one batch of telemetry [s].
    compensate_offset : bool
        Whether the controller is set against an offset of the amplifier.
    decision : DecisionSettings
        How dead zone and gains are decided on.
    redesign : ControllerGains
        Gains that a simulated decision may set.
    """

    estimator: EstimatorChoice
    inverse_filter: InverseFilterSettings
    output_error: OutputErrorSettings
    believed: PlantModel
    link: LinkSettings
    dead_zone: DeadZoneSettings
    telemetry_period: float
    compensate_offset: bool
    decision: DecisionSettings
    redesign: ControllerGains


@dataclass(frozen=True, eq=False)
class LoopParameters:
    """The parameters of all nodes, of which a few differ from run to run.

    Attributes
    ----------
    parts : mapping
        The dataclasses by node, prefix and kind.
    """

    parts: Mapping[Part, Any]

    @classmethod
    def from_values(cls, values: Mapping[str, Mapping[str, Any]]) -> "LoopParameters":
        """Return the parameters with given values.

        Parameters
        ----------
        values : mapping of str to mapping
            For each node values by flat name, each of which was checked; the defaults hold for
            what is missing.

        Raises
        ------
        ValueError
            If values do not go together, with one line that says which.
        """
        parts: dict[Part, Any] = {}
        for node, table in TABLES.items():
            try:
                built = parameter_sets(table, values.get(node, {}))
            except ValueError as error:
                raise ValueError(f"{node}: {in_parameter_names(str(error), table)}") from error
            for (prefix, kind), instance in zip(table, built, strict=True):
                parts[node, prefix, kind] = instance
        return cls(parts)

    def part(self, node: str, prefix: str, kind: type[Any]) -> Any:
        """Return the parameters of a node that a dataclass holds below a prefix."""
        return self.parts[node, prefix, kind]

    def with_values(self, changes: Mapping[tuple[str, str], Any]) -> "LoopParameters":
        """Return the parameters with other values; what does not change is shared, not copied.

        Parameters
        ----------
        changes : mapping of (str, str)
            Values by node and flat name, each of which was checked.

        Raises
        ------
        ValueError
            If values do not go together, with one line that says which.
        """
        by_part: dict[Part, dict[str, Any]] = {}
        for (node, name), value in changes.items():
            part, field = part_of(node, name)
            by_part.setdefault(part, {})[field] = value
        parts = dict(self.parts)
        for part, fields in by_part.items():
            try:
                parts[part] = _with_fields(parts[part], tuple(fields.items()))
            except ValueError as error:
                node = part[0]
                raise ValueError(
                    f"{node}: {in_parameter_names(str(error), TABLES[node])}"
                ) from error
        return LoopParameters(parts)

    def scenario(self, duration: float, seed: int | None = None) -> Scenario:
        """Return the loop without its twin.

        Parameters
        ----------
        duration : float
            Simulated time [s].
        seed : int, optional
            Seed of the sensor in place of its own; an ideal one draws nothing.

        Raises
        ------
        ValueError
            If values do not go together.
        """
        settings: ControllerSettings = self.part(CONTROLLER_NODE, "", ControllerSettings)
        sensor: SensorParameters = self.part(PLANT_NODE, "sensor", SensorParameters)
        if seed is not None and not sensor.is_ideal:
            sensor = replace(sensor, seed=seed)
        return Scenario(
            duration=duration,
            reference=self.part(CONTROLLER_NODE, "reference", ReferenceProfile),
            gap=self.part(PLANT_NODE, "gap", GapProfile),
            dead_zone=settings.dead_zone_tolerance,
            model=self._mechanism(PLANT_NODE, MECHANISM),
            gains=self.part(CONTROLLER_NODE, "pid", PidGains),
            sampling=self.part(PLANT_NODE, "", Sampling),
            sensor=sensor,
            actuator=self.part(PLANT_NODE, "actuator", ActuatorParameters),
            voltage_limit=settings.voltage_limit,
            voltage_offset=settings.voltage_offset,
            notch=self.part(CONTROLLER_NODE, "notch", NotchFilter),
        )

    def twin(self, seed: int | None = None) -> TwinSetup:
        """Return the twin.

        Parameters
        ----------
        seed : int, optional
            Seed of random delays and losses in place of the link's own.
        """
        link: LinkSettings = self.part(TWIN_NODE, "", LinkSettings)
        if seed is not None:
            link = replace(link, link_seed=seed)
        settings: TwinSettings = self.part(TWIN_NODE, "", TwinSettings)
        if not settings.reconfigure:
            # A twin that only estimates is one whose requests never arrive.
            link = replace(link, request_loss=1.0)
        plant: PlantSettings = self.part(PLANT_NODE, "", PlantSettings)
        return TwinSetup(
            self.part(TWIN_NODE, "estimator", EstimatorChoice),
            self.part(TWIN_NODE, "estimator", InverseFilterSettings),
            self.part(TWIN_NODE, "output_error", OutputErrorSettings),
            self._mechanism(TWIN_NODE, BELIEVED),
            link,
            self.part(TWIN_NODE, "dead_zone", DeadZoneSettings),
            plant.telemetry_period,
            settings.compensate_offset,
            self.part(TWIN_NODE, "decision", DecisionSettings),
            ControllerGains(
                self.part(TWIN_NODE, "redesign", PidGains),
                self.part(TWIN_NODE, "redesign", NotchFilter),
            ),
        )

    def _mechanism(self, node: str, parts: Sequence[tuple[str, type[Any]]]) -> PlantModel:
        return PlantModel(*(self.parts[node, prefix, kind] for prefix, kind in parts))


def simulate_setup(scenario: Scenario, twin: TwinSetup, keep: Sequence[str]) -> TwinTrajectory:
    """Simulate a loop with its twin.

    Parameters
    ----------
    scenario : Scenario
        The loop.
    twin : TwinSetup
        The twin.
    keep : sequence of str
        Signals to keep; see :func:`bdt_study.simulation.closed_loop.simulate`.

    Raises
    ------
    ValueError
        If the estimator cannot be had.
    """
    estimator = create_estimator(
        twin.estimator, twin.believed, twin.inverse_filter, twin.output_error
    )
    return simulate_with_twin(
        scenario,
        estimator,
        twin.link,
        twin.dead_zone,
        twin.telemetry_period,
        keep,
        compensate_offset=twin.compensate_offset,
        decision=twin.decision,
        believed=twin.believed,
        redesign=twin.redesign,
    )


# Checking a part takes as long as a fifth of a simulated second, and grids repeat their values.
@lru_cache(maxsize=1024)
def _with_fields(part: Any, fields: tuple[tuple[str, Any], ...]) -> Any:
    return replace(part, **dict(fields))


def part_of(node: str, name: str) -> tuple[Part, str]:
    """Return the part and the field of a parameter of a node by its flat name.

    Raises
    ------
    KeyError
        If the node has no such parameter.
    """
    return _PLACES[node, name]


_PLACES: dict[tuple[str, str], tuple[Part, str]] = {
    (node, full_name(prefix, field)): ((node, prefix, kind), field)
    for node, table in TABLES.items()
    for prefix, kind in table
    for field in kind.__dataclass_fields__
}
