"""What is known of a machine before its telemetry is looked at: hardly more than the magnitude."""

import numpy as np

from bdt_twin.fit_result import Fit
from bdt_twin.machine_knowledge import EFFECTS, MachineKnowledge, independent_knowledge
from bdt_twin.model_factors import FACTORS
from bdt_twin.noise_levels import SMALLEST_NOISE

FACTOR_SPREAD = (0.7, 0.7, 0.7)
"""Prior standard deviations of the logarithms of ``FACTORS``: twice as large, or half."""
CALIBRATED_EFFECTS = ("friction_voltage", "voltage_offset", "delay", "drift")
"""Those of ``EFFECTS`` that a calibration looks for, the first ones; a machine has no others."""
EFFECT_SPREAD = (1.0, 0.2, 2e-3, 1e-5)
"""Prior standard deviations of ``CALIBRATED_EFFECTS`` [V, V, s, m/s]."""
_NONE = (1e-9,) * (len(EFFECTS) - len(CALIBRATED_EFFECTS))
HELD_SPREAD = (1e-7, 1e-7, 1e-7, 1e-7, 1e-7, 1e-9, 1e-12, *_NONE)
"""Standard deviations of ``FACTORS`` and ``EFFECTS`` that stay what they are."""
PLAUSIBLE = 4.0
"""Standard deviations of the prior within which a machine is one."""
UNTOLD = 1e-9
"""Standard deviation of an effect that is not looked for yet."""


def wide_knowledge(friction: float) -> MachineKnowledge:
    """Return a prior that hardly says more than the order of magnitude.

    Parameters
    ----------
    friction : float
        Expected voltage of the friction [V].
    """
    return independent_knowledge(friction, (*FACTOR_SPREAD, *EFFECT_SPREAD, *_NONE))


def without_late_readings(knowledge: MachineKnowledge) -> MachineKnowledge:
    """Return a prior that holds delay and drift: at reversals a gap is like a late reading."""
    spread = np.diag(knowledge.covariance).copy()
    spread[[len(FACTORS) + EFFECTS.index(name) for name in ("delay", "drift")]] = UNTOLD**2
    return knowledge._replace(covariance=np.diag(spread))


def is_plausible(fit: Fit, knowledge: MachineKnowledge) -> bool:
    """Tell whether a machine is what the prior allows, and not all of it noise of the machine."""
    off = np.abs(fit.machine.expected - knowledge.expected)
    spread = np.sqrt(np.diag(knowledge.covariance))
    return bool((off <= PLAUSIBLE * spread).all()) and fit.levels.reading > 2.0 * SMALLEST_NOISE
