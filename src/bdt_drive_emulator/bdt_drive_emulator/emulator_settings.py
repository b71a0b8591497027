"""Settings of the emulator: how a device differs from an ideal one."""

from dataclasses import dataclass

from bdt_msgs_py.quantities import quantity, validate


@dataclass(frozen=True)
class EmulatorSettings:
    """Clock and transport of an emulated device."""

    frame_rate: float = quantity(
        1000.0,
        "Hz",
        "rate of the frames with samples; divides the sampling rate",
        minimum=1.0,
        maximum=1e4,
    )
    clock_error: float = quantity(
        0.0,
        "",
        "relative error of the device's clock: 0.001 samples a thousandth too fast",
        minimum=-0.01,
        maximum=0.01,
    )
    jitter: float = quantity(
        0.0, "s", "largest delay of a frame on its way, at random", minimum=0.0, maximum=0.1
    )
    seed: int = quantity(
        1, "", "seed of the jitter and of what faults do", minimum=0, maximum=2_147_483_647
    )

    def __post_init__(self) -> None:
        validate(self)
