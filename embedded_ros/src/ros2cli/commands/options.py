"""Arguments that several verbs share."""

import argparse
import os.path

from ros2cli.grammar import Argument, flag, option, word
from ros2cli.number_types import COUNT, SECONDS

__all__ = [
    "BAG",
    "BAG_STORAGES",
    "DISCOVERY",
    "SIMULATED_TIME",
    "SPIN_TIME_S",
    "quality_of_service",
]

#: How long to listen for the graph; peers on this machine answer in a tenth of it.
SPIN_TIME_S = 0.5

DISCOVERY = (
    option(
        "--spin-time",
        metavar="SECONDS",
        type=SECONDS,
        default=SPIN_TIME_S,
        about="how long to listen for other nodes before answering (default: %(default)g s)",
    ),
    flag("--no-daemon", about="no effect: each command listens for itself, no daemon is asked"),
)

SIMULATED_TIME = flag("-s", "--use-sim-time", about="go by /clock instead of the computer's time")

BAG_STORAGES = ("mcap", "sqlite3")


def _existing(path: str) -> str:
    if os.path.exists(path):  # noqa: PTH110 - pathlib would cost each command its import
        return path
    raise argparse.ArgumentTypeError(f"there is no '{path}'")


BAG = (
    word("bag_path", "folder of the bag, or a single .mcap or .db3 file", type=_existing),
    option(
        "-s",
        "--storage",
        choices=BAG_STORAGES,
        about="format of the file; its ending tells by default",
    ),
)

# Their names in rclpy, which help does not wait for; a test compares them.
_PRESETS = (
    "unknown default system_default sensor_data services_default parameters parameter_events "
    "action_status_default best_available"
)
_POLICIES = {
    "history": ("system_default keep_last keep_all unknown", "which messages a queue keeps"),
    "reliability": (
        "system_default reliable best_effort unknown best_available",
        "whether lost messages are sent again",
    ),
    "durability": (
        "system_default transient_local volatile unknown best_available",
        "whether who comes late gets what was sent before",
    ),
    "liveliness": (
        "system_default automatic manual_by_topic unknown best_available",
        "how a publisher shows that it is alive",
    ),
}


def quality_of_service(preset: str) -> tuple[Argument, ...]:
    """Options for a QoS profile; `preset` is the one without them."""
    policies = (
        option(
            f"--qos-{policy}", choices=keys.split(), metavar="POLICY", about=f"{about}: %(choices)s"
        )
        for policy, (keys, about) in _POLICIES.items()
    )
    return (
        option(
            "--qos-profile",
            choices=_PRESETS.split(),
            default=preset,
            metavar="PROFILE",
            about="QoS to begin with, instead of %(default)s: %(choices)s",
        ),
        option("--qos-depth", metavar="N", type=COUNT, about="messages that a queue holds"),
        *policies,
    )
