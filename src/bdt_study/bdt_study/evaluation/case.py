"""One of the conditions under which estimators are compared."""

from dataclasses import dataclass

import numpy as np

from bdt_study.evaluation.machine_effects import NO_EFFECTS, MachineEffects
from bdt_twin.link import PAPER_LINK, LinkSettings


@dataclass(frozen=True)
class Case:
    """What is wrong with the data, the model and the link.

    Attributes
    ----------
    name : str
        Name on the command line.
    description : str
        One line.
    noise, quantization : float
        Noise (rms) and quantization of the sensor [m].
    drop_probability : float
        Probability that the sensor drops a sample.
    gain_error, mechanics_error, damping_error : float
        Largest deviation of the plant's motor gain k_B, of its masses and stiffnesses, and of its
        dampings from what the twin believes, as fractions: laboratory values have either sign.
    voltage_limit : float
        Saturation of the actuator [V]; 0 for none.
    sampling_rate : float
        Rate of the telemetry [Hz].
    link : LinkSettings
        Delays and losses between twin and controller.
    gap : str
        Kind of gap profile; empty for any that grows smoothly or not at all.
    effects : MachineEffects
        What the machine has that the paper's mechanism has not, and the twin is not told of.
    decision : str
        How a twin decides that is not told how, as in its parameter ``decision.kind``.
    """

    name: str
    description: str
    noise: float = 0.0
    quantization: float = 0.0
    drop_probability: float = 0.0
    gain_error: float = 0.0
    mechanics_error: float = 0.0
    damping_error: float = 0.0
    voltage_limit: float = 0.0
    sampling_rate: float = 5000.0
    link: LinkSettings = PAPER_LINK
    gap: str = ""
    effects: MachineEffects = NO_EFFECTS
    decision: str = "equation_9"

    @property
    def reading_error(self) -> float:
        """Standard deviation of what a reading is off [m]: noise and rounding."""
        return float(np.hypot(self.noise, self.quantization / np.sqrt(12.0)))

    @property
    def is_exact(self) -> bool:
        """Whether the twin's model is the plant, so that the Cramér-Rao bound applies."""
        errors = self.gain_error or self.mechanics_error or self.damping_error
        return not errors and self.effects == NO_EFFECTS
