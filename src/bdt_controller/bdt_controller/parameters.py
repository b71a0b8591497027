"""Parameters of the controller node: which dataclass declares which names."""

from bdt_controller.controller import ControllerSettings
from bdt_controller.notch import NotchFilter
from bdt_controller.pid import PidGains
from bdt_controller.plausibility import PlausibilitySettings
from bdt_controller.reference import ReferenceProfile
from bdt_msgs_py.real_time import RealTimeSettings

PARAMETERS = (
    ("", ControllerSettings),
    ("pid", PidGains),
    ("notch", NotchFilter),
    ("reference", ReferenceProfile),
    ("plausibility", PlausibilitySettings),
    ("real_time", RealTimeSettings),
)
"""Prefix and dataclass, in the order in which the node declares them."""
