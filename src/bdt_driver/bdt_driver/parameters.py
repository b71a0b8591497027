"""Parameters of the driver node: which dataclass declares which names."""

from bdt_driver.driver_settings import DriveLimits, DriverSettings
from bdt_msgs_py.real_time import RealTimeSettings

PARAMETERS = (("", DriverSettings), ("limits", DriveLimits), ("real_time", RealTimeSettings))
"""Prefix and dataclass, in the order in which the node declares them."""
