"""Parameters of the controller node: which dataclass declares which names."""

from bdt_controller.controller import ControllerSettings
from bdt_controller.notch import NotchFilter
from bdt_controller.pid import PidGains
from bdt_controller.plausibility import PlausibilitySettings
from bdt_controller.reference import ReferenceProfile

PARAMETERS = (
    ("", ControllerSettings),
    ("pid", PidGains),
    ("notch", NotchFilter),
    ("reference", ReferenceProfile),
    ("plausibility", PlausibilitySettings),
)
"""Prefix and dataclass, in the order in which the node declares them."""
