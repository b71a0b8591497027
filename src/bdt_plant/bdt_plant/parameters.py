"""Parameters of the plant node: which dataclass declares which names."""

from bdt_plant.actuator import ActuatorParameters
from bdt_plant.amplifier_lag import AmplifierLag
from bdt_plant.cogging import CoggingParameters
from bdt_plant.gap_profile import GapProfile
from bdt_plant.lead_screw import LeadScrewParameters
from bdt_plant.limits import HardwareLimits
from bdt_plant.motor import MotorParameters
from bdt_plant.plant import Sampling
from bdt_plant.plant_settings import PlantSettings
from bdt_plant.pushes import PushParameters
from bdt_plant.screw_load import ScrewMechanics
from bdt_plant.sensor import SensorParameters
from bdt_plant.stiffening_tower import BeamParameters
from bdt_plant.stribeck import StribeckParameters
from bdt_plant.structure import StructureParameters

MECHANISM = (
    ("motor", MotorParameters),
    ("lead_screw", LeadScrewParameters),
    ("structure", StructureParameters),
    ("motor", StribeckParameters),
    ("motor", CoggingParameters),
    ("lead_screw", ScrewMechanics),
    ("structure", BeamParameters),
    ("push", PushParameters),
    ("actuator", AmplifierLag),
)
"""Those of a :class:`bdt_plant.plant.PlantModel`, in its order."""

PARAMETERS = (
    ("", PlantSettings),
    ("", Sampling),
    *MECHANISM,
    ("gap", GapProfile),
    ("actuator", ActuatorParameters),
    ("sensor", SensorParameters),
    ("limits", HardwareLimits),
)
"""Prefix and dataclass, in the order in which the node declares them."""
