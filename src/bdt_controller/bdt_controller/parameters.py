"""Parameters of the controller node: which dataclass declares which names."""

from bdt_controller.controller import ControllerSettings
from bdt_controller.pid import PidGains
from bdt_controller.reference import Reference

PARAMETERS = (("", ControllerSettings), ("pid", PidGains), ("reference", Reference))
"""Prefix and dataclass, in the order in which the node declares them."""
