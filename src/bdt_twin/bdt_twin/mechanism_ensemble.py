"""Mechanisms drawn from what the twin knows: those for which a decision has to be right."""

import math

import numpy as np
from numpy.typing import NDArray

from bdt_plant.plant import PlantModel, discretize_plant
from bdt_plant.quick_exponential import quick_exponential
from bdt_twin.decision_loop import HOLD, Member
from bdt_twin.estimator import Estimate
from bdt_twin.machine_knowledge import EFFECT_LIMITS, EFFECTS, TOP_MASS, MachineKnowledge
from bdt_twin.model_factors import FACTORS, model_with

FloatArray = NDArray[np.float64]

LARGEST_LOGARITHM = 0.6
"""Largest logarithm of a factor that is drawn: beyond, a constant may leave its limits."""


class MechanismEnsemble:
    """Draws mechanisms; the same numbers for every decision, so that these can be compared.

    Parameters
    ----------
    model : PlantModel
        The mechanism, as the twin knows it.
    members : int
        How many; the first is the expected one.
    control_rate : float
        Rate of measurements [Hz].
    seed : int
        Number of the draws.
    """

    def __init__(self, model: PlantModel, members: int, control_rate: float, seed: int) -> None:
        self._model = model
        self._period = 1.0 / (HOLD * control_rate)
        generator = np.random.default_rng((seed, 20_261_122))
        # Each constant has its numbers, whatever constants there are beside it.
        self._draws = generator.standard_normal((2 + len(FACTORS) + len(EFFECTS), members)).T
        self._draws[0] = 0.0
        self._places = np.linspace(-1.0, 1.0, members)

    def draw(
        self,
        estimate: Estimate,
        machine: MachineKnowledge | None,
        soonest: float,
        latest: float,
        noise: float = 0.0,
    ) -> list[Member]:
        """Return the mechanisms.

        Parameters
        ----------
        estimate : Estimate
            What is known of the gap, which must be.
        machine : MachineKnowledge or None
            What is known of the machine; None for the model alone.
        soonest, latest : float
            Times between which the decision is in force [s]: half of the mechanisms have the gap of
            the one, half that of the other.
        noise : float
            Standard deviation of the noise of a reading [m].
        """
        members = []
        for number, draw in enumerate(self._draws):
            at = latest if number % 2 == 0 else soonest
            gap = _gap(estimate, at, float(draw[0]), float(draw[1]))
            model, disturbance, delay = self._machine(estimate, machine, draw[2:])
            members.append(
                Member(
                    discretize_plant(model, self._period, quick_exponential),
                    gap,
                    disturbance,
                    max(round(delay / self._period), 0),
                    float(self._places[number]),
                    noise,
                )
            )
        return members

    def _machine(
        self, estimate: Estimate, machine: MachineKnowledge | None, draw: FloatArray
    ) -> tuple[PlantModel, float, float]:
        """Return model, voltage that is not taken back [V], and by how much a loop is late [s]."""
        if machine is None:
            factors = np.zeros(len(FACTORS))
            factors[FACTORS.index("gain")] = math.log(estimate.gain_correction)
            return model_with(self._model, factors), 0.0, 0.0
        drawn = machine.expected + _spread(machine.covariance, draw)
        effects = dict(zip(EFFECTS, drawn[len(FACTORS) :].tolist(), strict=True))
        expected = dict(zip(EFFECTS, machine.expected[len(FACTORS) :].tolist(), strict=True))
        factors = np.clip(drawn[: len(FACTORS)], -LARGEST_LOGARITHM, LARGEST_LOGARITHM)
        top_mass = np.clip(effects["top_mass"], *EFFECT_LIMITS[:, TOP_MASS])
        model = model_with(self._model, np.append(factors, top_mass))
        motor = model.motor
        friction = max(effects["friction_voltage"], 0.0) * motor.torque_constant / motor.resistance
        motor = type(motor)(**vars(motor) | {"coulomb_friction": friction})
        model = PlantModel(motor, model.lead_screw, model.structure)
        disturbance = effects["voltage_offset"] - expected["voltage_offset"]
        # To a loop, a late voltage is the same as a late reading.
        return model, disturbance, effects["delay"] + effects["voltage_lag"]


def _gap(estimate: Estimate, at: float, draw: float, growth_draw: float) -> float:
    """Return a gap at a time [rad]; a gap wears out and does not heal."""
    age = max(at - estimate.time, 0.0)
    doubt = estimate.uncertainty if math.isfinite(estimate.uncertainty) else 0.0
    growth = max(estimate.growth + growth_draw * estimate.growth_uncertainty, 0.0)
    return max(estimate.gap + draw * doubt + growth * age, 0.0)


def _spread(covariance: FloatArray, draw: FloatArray) -> FloatArray:
    """Return a deviation with a covariance, shape (n,), by Cholesky's factor in a fixed order."""
    size = draw.size
    rows = covariance.tolist()
    factor = [[0.0] * size for _ in range(size)]
    for i in range(size):
        for j in range(i + 1):
            rest = rows[i][j]
            for k in range(j):
                rest -= factor[i][k] * factor[j][k]
            if i == j:
                # Rounding may leave a little less than nothing of what another constant tells.
                factor[i][i] = math.sqrt(max(rest, 0.0))
            elif factor[j][j] > 0.0:
                factor[i][j] = rest / factor[j][j]
    numbers = draw.tolist()
    found = []
    for i in range(size):
        value = 0.0
        for j in range(i + 1):
            value += factor[i][j] * numbers[j]
        found.append(value)
    return np.array(found)
