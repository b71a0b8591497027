"""Parameters of the driver node: which dataclass declares which names."""

from bdt_driver.driver_settings import DriveLimits, DriverSettings

PARAMETERS = (("", DriverSettings), ("limits", DriveLimits))
"""Prefix and dataclass, in the order in which the node declares them."""
