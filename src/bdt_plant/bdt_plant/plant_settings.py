"""Settings of the plant node that are about running, not about the mechanism."""

from dataclasses import dataclass

from bdt_msgs_py.quantities import quantity, validate


@dataclass(frozen=True)
class PlantSettings:
    """How the plant node runs; see the README for lockstep and real time."""

    mode: str = quantity(
        "lockstep",
        "",
        "advance when the command has come, or by the wall clock",
        choices=("lockstep", "realtime"),
    )
    duration: float = quantity(
        0.0,
        "s",
        "simulated time after which the node ends; 0 for endless",
        minimum=0.0,
        maximum=1e9,
    )
    telemetry_period: float = quantity(
        0.1, "s", "simulated time covered by one telemetry batch", minimum=1e-4, maximum=1e3
    )
    clock_rate: float = quantity(
        50.0, "Hz", "rate of /clock in simulated time", minimum=0.1, maximum=1e5
    )
    command_timeout: float = quantity(
        0.1,
        "s",
        "realtime: age of the last command beyond which the voltage is 0; both modes: time without "
        "an answer after which commands of another source are taken",
        minimum=1e-3,
        maximum=1e3,
    )
    lockstep_timeout: float = quantity(
        10.0,
        "s",
        "lockstep: wall time without a command, or without progress of a follower that is awaited, "
        "after which the node gives up",
        minimum=0.1,
        maximum=1e6,
    )
    resend_period: float = quantity(
        0.2,
        "s",
        "lockstep: wall time after which an unanswered measurement is sent again",
        minimum=1e-3,
        maximum=1e3,
    )
    pace: float = quantity(
        0.0,
        "",
        "lockstep: simulated seconds in a second of wall time at most; 0 for as fast as it goes",
        minimum=0.0,
        maximum=1e3,
        reconfigurable=True,
    )
    pause_at: float = quantity(
        1e9,
        "s",
        "lockstep: simulated time from which on the plant waits until this is set to a later one",
        minimum=0.0,
        maximum=1e9,
        reconfigurable=True,
    )
    lockstep_followers: tuple[str, ...] = quantity(
        ("",), "", "lockstep: nodes whose progress messages the plant waits for"
    )

    def __post_init__(self) -> None:
        validate(self)
