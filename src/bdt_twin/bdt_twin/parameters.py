"""Parameters of the twin node: which dataclass declares which names."""

from bdt_controller.notch import NotchFilter
from bdt_controller.pid import PidGains
from bdt_msgs_py.parameter_tables import ReadAtStart
from bdt_plant.lead_screw import LeadScrewParameters
from bdt_plant.motor import MotorParameters
from bdt_plant.structure import StructureParameters
from bdt_twin.dead_zone_tolerance import DeadZoneSettings
from bdt_twin.decision_settings import DecisionSettings
from bdt_twin.estimator_choice import EstimatorChoice
from bdt_twin.inverse_filter import InverseFilterSettings
from bdt_twin.link import LinkSettings
from bdt_twin.output_error_settings import OutputErrorSettings
from bdt_twin.twin_settings import TwinSettings

PARAMETERS = (
    ("", TwinSettings),
    ("", LinkSettings),
    ("dead_zone", DeadZoneSettings),
    ("estimator", EstimatorChoice),
    ("estimator", InverseFilterSettings),
    ("output_error", OutputErrorSettings),
    (ReadAtStart("motor"), MotorParameters),
    ("lead_screw", LeadScrewParameters),
    ("structure", StructureParameters),
    ("decision", DecisionSettings),
    (ReadAtStart("pid"), PidGains),
    (ReadAtStart("notch"), NotchFilter),
    (ReadAtStart("redesign"), PidGains),
    (ReadAtStart("redesign"), NotchFilter),
)
"""Prefix and dataclass, in the order in which the node declares them."""
