"""Settings of the recorder node."""

from dataclasses import dataclass

from bdt_msgs_py.quantities import quantity, validate


@dataclass(frozen=True)
class RecorderSettings:
    """Where, what and how the recorder writes."""

    bag: str = quantity("bag", "", "folder of the bag, which must not exist yet")
    storage: str = quantity(
        "mcap", "", "storage of the rosbag2 format", choices=("mcap", "sqlite3")
    )
    compression: str = quantity(
        "none",
        "",
        "of the chunks of an mcap as they are written, of whole sqlite3 files at the end",
        choices=("none", "zstd"),
    )
    split_size: int = quantity(
        0,
        "B",
        "size of a file from which on the next one is begun; 0 for one file",
        minimum=0,
        maximum=10**12,
    )
    split_duration: float = quantity(
        0.0, "s", "wall time that a file covers; 0 for one file", minimum=0.0, maximum=1e6
    )
    topics: str = quantity(
        "", "", "names with spaces between them; empty for all topics of this project"
    )

    def __post_init__(self) -> None:
        validate(self)


PARAMETERS = (("", RecorderSettings),)
"""Prefix and dataclass, in the order in which the node declares them."""

RECORDING_OPTIONS = ("storage", "compression", "split_size", "split_duration")
"""Parameters that are options of the commands that record."""
