"""Settings of the recorder node."""

from dataclasses import dataclass

from bdt_msgs_py.quantities import quantity, validate


@dataclass(frozen=True)
class RecorderSettings:
    """Where and how the recorder writes."""

    bag: str = quantity("bag", "", "folder of the bag, which must not exist yet")
    storage: str = quantity(
        "mcap", "", "storage of the rosbag2 format", choices=("mcap", "sqlite3")
    )

    def __post_init__(self) -> None:
        validate(self)


PARAMETERS = (("", RecorderSettings),)
"""Prefix and dataclass, in the order in which the node declares them."""
