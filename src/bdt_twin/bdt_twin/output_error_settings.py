"""Settings of the estimator by output error."""

from dataclasses import dataclass

import numpy as np

from bdt_msgs_py.quantities import quantity, validate

WALKING_STEPS = 5.0
"""Factor by which the steps of a simulation may be longer where a walk of the motor hides it."""
FEWEST_PERIODS = 2
"""Periods of the residual rate that the shortest stretch must hold to be compared at all."""


@dataclass(frozen=True)
class OutputErrorSettings:
    """Settings of the estimator by output error."""

    window: float = quantity(
        20.0, "s", "length of the newest data that one estimate rests on", minimum=1.0, maximum=1e3
    )
    update_period: float = quantity(
        1.0, "s", "time between two estimates", minimum=1e-3, maximum=1e4
    )
    residual_rate: float = quantity(
        125.0,
        "Hz",
        "rate at which measured and simulated position are compared: means over its periods",
        minimum=1.0,
        maximum=1e5,
    )
    simulation_rate: float = quantity(
        5000.0,
        "Hz",
        "lowest rate at which a window is simulated, or a fifth of it where the motor walks: of "
        "faster telemetry several samples share a step, as many as divide a residual's period",
        minimum=1.0,
        maximum=1e5,
    )
    knot_spacing: float = quantity(
        1.0,
        "s",
        "spacing of the knots between which the gap grows evenly",
        minimum=0.1,
        maximum=1e3,
    )
    growth_change: float = quantity(
        float(np.deg2rad(0.02)),
        "rad/s^1.5",
        "usual change of the gap's growth rate in a second",
        minimum=1e-9,
        maximum=1e3,
    )
    shortest_stretch: float = quantity(
        1.0, "s", "shortest data between two holes that are used", minimum=0.1, maximum=1e3
    )
    largest_uncertainty: float = quantity(
        float(np.deg2rad(0.75)),
        "rad",
        "standard uncertainty of the gap above which a window has taught nothing",
        minimum=1e-6,
        maximum=100.0,
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.knot_spacing > self.window:
            raise ValueError(
                f"OutputErrorSettings.knot_spacing = {self.knot_spacing!r} s: "
                f"must be at most the window ({self.window:g} s)"
            )
        if self.shortest_stretch > self.window:
            raise ValueError(
                f"OutputErrorSettings.shortest_stretch = {self.shortest_stretch!r} s: "
                f"must be at most the window ({self.window:g} s)"
            )

        if self.residual_rate * self.shortest_stretch < FEWEST_PERIODS:
            raise ValueError(
                f"OutputErrorSettings.residual_rate = {self.residual_rate!r} Hz: must be at least "
                f"{FEWEST_PERIODS / self.shortest_stretch:g} Hz, {FEWEST_PERIODS} periods in the "
                f"shortest stretch ({self.shortest_stretch:g} s)"
            )

    def samples_per_update(self, sampling_rate: float) -> int:
        """Return the number of samples in an update period.

        Raises
        ------
        ValueError
            If it is not whole.
        """
        samples = self.update_period * sampling_rate
        if abs(samples - round(samples)) > 1e-6 or round(samples) < 1:
            raise ValueError(
                f"OutputErrorSettings.update_period = {self.update_period!r} s: "
                f"must be a whole number of samples at {sampling_rate:g} Hz"
            )
        return round(samples)

    def samples_per_block(self, sampling_rate: float) -> int:
        """Return the number of samples over which the residual is averaged."""
        return max(round(sampling_rate / self.residual_rate), 1)

    def samples_per_step(self, sampling_rate: float, *, walks: bool) -> int:
        """Return the number of samples that share a step of the simulation; divides a block.

        Parameters
        ----------
        sampling_rate : float
            Sampling rate of the telemetry [Hz].
        walks : bool
            Whether the motor walks, which hides a little that longer steps leave out.
        """
        block = self.samples_per_block(sampling_rate)
        lowest = self.simulation_rate / WALKING_STEPS if walks else self.simulation_rate
        most = max(int(sampling_rate / lowest + 1e-6), 1)
        return max(number for number in range(1, min(most, block) + 1) if block % number == 0)
