"""Settings of the twin node that are about the controller."""

from dataclasses import dataclass

from bdt_msgs_py.quantities import quantity, validate
from bdt_msgs_py.topics import CONTROLLER_NODE


@dataclass(frozen=True)
class TwinSettings:
    """What the twin does with its estimates."""

    reconfigure: bool = quantity(
        True, "", "set the controller's dead zone; false to estimate only", reconfigurable=True
    )
    compensate_offset: bool = quantity(
        True,
        "",
        "set the controller's voltage_offset with the dead zone, against an offset of the "
        "amplifier that the estimator knows; false to leave it alone",
        reconfigurable=True,
    )
    controller_node: str = quantity(CONTROLLER_NODE, "", "name of the node whose dead zone is set")
    service_timeout: float = quantity(
        2.0,
        "s",
        "wall time after which an unanswered reconfiguration counts as failed and is tried again",
        minimum=0.01,
        maximum=1e4,
    )
    state_file: str = quantity(
        "",
        "",
        "file in which the twin keeps what is in force and what it knows, for the time after its "
        "end; empty for none",
    )
    state_longest_age: float = quantity(
        86400.0,
        "s",
        "wall time after which a state file is of no use any more",
        minimum=0.0,
        maximum=1e9,
    )

    def __post_init__(self) -> None:
        validate(self)
