"""Settings of the driver node: rates, times, and the limits that are its own."""

from dataclasses import dataclass

from bdt_msgs_py.quantities import quantity, validate

ENGAGE_PERIODS = 100
"""Control periods that engaging takes at least, so that no step is above 1 % of the limit."""


@dataclass(frozen=True)
class DriverSettings:
    """Which drive, and how often it is read."""

    driver: str = quantity(
        "",
        "",
        "module:name of the drive's class, with open, read, write, stop and close; it gets the "
        "parameters drive.* as arguments",
    )
    control_rate: float = quantity(
        500.0, "Hz", "rate of reading the position and publishing it", minimum=1.0, maximum=1e4
    )
    sampling_rate: float = quantity(
        0.0,
        "Hz",
        "rate of the samples that a reading brings along, by the clock of the hardware; 0 for a "
        "drive that samples when it is read",
        minimum=0.0,
        maximum=1e6,
    )
    telemetry_period: float = quantity(
        0.1, "s", "time covered by one telemetry batch", minimum=1e-3, maximum=1e3
    )
    command_timeout: float = quantity(
        0.1,
        "s",
        "time without a command, or in a call of the drive, after which the voltage is 0",
        minimum=1e-3,
        maximum=10.0,
    )
    engage_time: float = quantity(
        1.0,
        "s",
        "time in which commands come into force after arming, or after a silence",
        minimum=1e-3,
        maximum=100.0,
    )

    def __post_init__(self) -> None:
        validate(self)
        module, _, name = self.driver.partition(":")
        if self.driver and not (module and name):
            raise ValueError(f"DriverSettings.driver = {self.driver!r}: must be module:name")
        shortest = ENGAGE_PERIODS / self.control_rate
        if self.engage_time < shortest:
            raise ValueError(
                f"DriverSettings.engage_time = {self.engage_time!r} s: must be at least "
                f"{ENGAGE_PERIODS} control periods ({shortest:g} s)"
            )

    @property
    def telemetry_rate(self) -> float:
        """Rows of telemetry per second [Hz]."""
        return self.sampling_rate or self.control_rate


@dataclass(frozen=True)
class DriveLimits:
    """What the motor may get and where platform 3 may be, whatever is commanded."""

    voltage: float = quantity(
        24.0,
        "V",
        "largest motor voltage of either sign; what is commanded beyond is limited",
        minimum=1e-3,
        maximum=1e6,
    )
    voltage_rate: float = quantity(
        1e5, "V/s", "fastest change of the motor voltage", minimum=1e-3, maximum=1e9
    )
    lowest_position: float = quantity(
        -0.05,
        "m",
        "smallest position of platform 3; below it the drive is stopped",
        minimum=-1e3,
        maximum=1e3,
    )
    highest_position: float = quantity(
        0.05,
        "m",
        "largest position of platform 3; above it the drive is stopped",
        minimum=-1e3,
        maximum=1e3,
    )

    def __post_init__(self) -> None:
        validate(self)
        if not self.lowest_position < self.highest_position:
            raise ValueError(
                f"DriveLimits.highest_position = {self.highest_position!r} m: must be above "
                f"lowest_position ({self.lowest_position:g} m)"
            )

    def allow(self, position: float) -> bool:
        """Tell whether platform 3 is where it may be; false for NaN."""
        return self.lowest_position <= position <= self.highest_position
