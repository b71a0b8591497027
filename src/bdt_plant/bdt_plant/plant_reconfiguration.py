"""What of a simulated plant may change while it runs: gap, friction, noise, pace."""

from dataclasses import replace
from typing import NamedTuple

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from bdt_msgs_py.node_parameters import accepted, reconfigured, rejected
from bdt_plant.gap_profile import GapProfile
from bdt_plant.pace import Pace
from bdt_plant.plant import PlantModel
from bdt_plant.plant_settings import PlantSettings
from bdt_plant.plant_simulator import PlantSimulator
from bdt_plant.sensor import SensorParameters

OF_LOCKSTEP = ("pace", "pause_at")


class PlantConfiguration(NamedTuple):
    """The parameters of a plant of which some may change."""

    settings: PlantSettings
    model: PlantModel
    profile: GapProfile
    sensor: SensorParameters


class PlantReconfiguration:
    """Answers the parameter service of a plant, and has the simulator take what was accepted.

    Parameters
    ----------
    node : rclpy.node.Node
        The plant.
    configuration : PlantConfiguration
        What is in force.
    simulator : PlantSimulator
        The mechanism.
    pace : Pace
        The pace of simulated time.
    """

    def __init__(
        self, node: Node, configuration: PlantConfiguration, simulator: PlantSimulator, pace: Pace
    ) -> None:
        self._configuration, self._simulator, self._pace = configuration, simulator, pace
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._use)

    def _check(self, changes: list[Parameter]) -> SetParametersResult:
        if self._configuration.settings.mode != "lockstep":
            for change in changes:
                if change.name in OF_LOCKSTEP:
                    return rejected(f"{change.name}: is for a plant in lockstep, this is real time")
        try:
            self._simulator.check_model(self._changed(changes).model)
        except ValueError as error:
            return rejected(str(error))
        return accepted()

    def _use(self, changes: list[Parameter]) -> None:
        before, self._configuration = self._configuration, self._changed(changes)
        settings, model, profile, sensor = self._configuration
        if settings != before.settings:
            self._pace.configure(settings.pace, settings.pause_at)
        if self._configuration[1:] != before[1:]:
            self._simulator.reconfigure(model, profile, sensor)

    def _changed(self, changes: list[Parameter]) -> PlantConfiguration:
        settings, model, profile, sensor = self._configuration
        motor = reconfigured(model.motor, "motor", changes)
        return PlantConfiguration(
            reconfigured(settings, "", changes),
            replace(model, motor=motor),
            reconfigured(profile, "gap", changes),
            reconfigured(sensor, "sensor", changes),
        )
