"""What decides by simulation beside an estimator, in the node and offline."""

from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bdt_plant.plant import PlantModel
from bdt_plant.quick_exponential import compiled_powers
from bdt_twin.decision import ControllerGains, Decision
from bdt_twin.decision_loop import compiled_steps
from bdt_twin.decision_settings import DecisionSettings
from bdt_twin.estimator import Estimate, Estimator
from bdt_twin.machine_knowledge import MachineKnowledge
from bdt_twin.next_fit import last_fit_of
from bdt_twin.simulated_decision import SimulatedDecision

FloatArray = NDArray[np.float64]


class Decider(Protocol):
    """Called with each batch of telemetry and the estimate that became due."""

    def __call__(
        self, rows: FloatArray, estimate: Estimate | None, *, begins: bool
    ) -> Decision | None:
        """Return a decision; None without one."""


def no_decider(rows: FloatArray, estimate: Estimate | None, *, begins: bool) -> Decision | None:
    """Decide nothing: the rule of the dead zone is all there is."""
    _ = rows, estimate, begins
    return None


def create_decider(
    settings: DecisionSettings,
    model: PlantModel,
    today: ControllerGains,
    redesign: ControllerGains,
    estimator: Estimator,
    delay: float,
    horizon: float,
    gains_in_force: Callable[[], Mapping[str, float]] = dict,
) -> Decider:
    """Return what decides.

    Parameters
    ----------
    settings : DecisionSettings
        How.
    model : PlantModel
        The mechanism, as the twin knows it.
    today, redesign : ControllerGains
        Gains of the controller, and those that they may be set to.
    estimator : Estimator
        What knows the mechanism; used where the estimator is.
    delay : float
        Time to the controller that has to be reckoned with [s].
    horizon : float
        Time for which a decision is to hold at least [s].
    gains_in_force : callable
        Returns the gains that a twin before has set, by the names of the controller's parameters;
        asked before the first decision.
    """
    if settings.kind == "equation_9":
        return no_decider
    offered = redesign if settings.reconfigure_gains else None
    # Whatever is not in numba's cache is compiled now, not when the first batch waits.
    compiled_powers()
    compiled_steps()
    decision = SimulatedDecision(settings, model, today, offered, horizon)
    resumes = True

    def decide(rows: FloatArray, estimate: Estimate | None, *, begins: bool) -> Decision | None:
        nonlocal resumes
        if begins:
            decision.restart()
            resumes = False
        # A hole has times alone.
        if np.isfinite(rows).all():
            decision.watch(rows)
        if estimate is None or not estimate.is_known:
            return None
        if resumes:
            decision.resume(gains_in_force())
            resumes = False
        machine, noise = _knowledge(estimator)
        return decision.decide(estimate, machine, float(rows[-1, 0]), delay, noise)

    return decide


def _knowledge(estimator: Estimator) -> tuple[MachineKnowledge | None, float]:
    """Return what an estimator knows of the machine and of the noise of a reading [m].

    None and zero from an estimator that knows nothing of them.
    """
    last_fit = last_fit_of(estimator)
    if last_fit is None:
        return None, 0.0
    return last_fit.fit.machine, last_fit.reading_noise
