"""How the twin decides on dead zone and gains, and what it knows of the controller for that."""

from dataclasses import dataclass

from bdt_msgs_py.quantities import quantity, validate

KINDS = ("equation_9", "simulate")


@dataclass(frozen=True)
class DecisionSettings:
    """How the twin decides."""

    kind: str = quantity(
        "equation_9",
        "",
        "equation_9 (a dead zone for the estimated gap), or simulate (the narrowest dead zone with "
        "which no simulated step of a mechanism that the twin thinks possible ends in a limit "
        "cycle)",
        choices=KINDS,
    )
    step_heights: tuple[float, ...] = quantity(
        (4e-3, 5e-3, 6.5e-3, 8e-3),
        "m",
        "heights of the steps that are simulated until telemetry has shown those of the loop",
        minimum=1e-6,
        maximum=10.0,
    )
    step_time: float = quantity(
        8.0,
        "s",
        "length of the steps that are simulated until telemetry has shown that of the loop's",
        minimum=1.0,
        maximum=100.0,
    )
    period: float = quantity(
        2.0,
        "s",
        "simulated time from one simulation to the next; in between the dead zone follows the "
        "gap in proportion",
        minimum=0.0,
        maximum=1e4,
    )
    members: int = quantity(
        12, "", "mechanisms that are drawn from what the twin knows", minimum=1, maximum=100
    )
    seed: int = quantity(
        1, "", "number of the draws, the same for every decision", minimum=0, maximum=2**31 - 1
    )
    reconfigure_gains: bool = quantity(
        False,
        "",
        "whether to set the gains of redesign.*, too, once they are better in simulation than "
        "those of the controller",
    )
    patience: float = quantity(
        8.0,
        "s",
        "time without a second of rest, and beyond what was expected, after which a decision is "
        "taken back",
        minimum=1.0,
        maximum=1e4,
    )
    probation: float = quantity(
        60.0,
        "s",
        "time for which eq. 9 is in force after a decision was taken back",
        minimum=0.0,
        maximum=1e6,
    )
    control_rate: float = quantity(
        500.0, "Hz", "rate at which the controller measures", minimum=10.0, maximum=1e4
    )
    voltage_limit: float = quantity(
        0.0,
        "V",
        "largest voltage that the controller commands; 0 for no limit",
        minimum=0.0,
        maximum=1e6,
    )

    @property
    def sets_gains(self) -> bool:
        """Whether gains may be set, and not the dead zone alone."""
        return self.kind == "simulate" and self.reconfigure_gains

    def __post_init__(self) -> None:
        validate(self)
        if not self.step_heights:
            raise ValueError("DecisionSettings.step_heights = []: must have at least one height")
