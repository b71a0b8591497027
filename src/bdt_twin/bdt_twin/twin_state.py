"""What a twin keeps beyond its end: the controller's settings in force, the gap and the machine."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bdt_plant.plant import PlantModel
from bdt_twin.estimator import Estimate
from bdt_twin.machine_knowledge import EFFECTS, MachineKnowledge
from bdt_twin.machine_recollection import MachineRecollection
from bdt_twin.model_factors import FACTORS

CONSTANTS = len(FACTORS) + len(EFFECTS)
"""Constants of a machine that are known with their covariance."""
LARGEST_TOLERANCE = 1.0
"""Dead-zone tolerance [m] that can be kept."""

Document = dict[str, Any]


@dataclass(frozen=True)
class RememberedGap:
    """The newest estimate of the gap, without the clock that it was stated by.

    Attributes
    ----------
    gap : float
        Backlash gap theta_b [rad].
    uncertainty : float
        Its standard uncertainty when it was made [rad]; NaN from an estimator that does not know
        how sure it is.
    growth, growth_uncertainty : float
        Growth rate of the gap and its standard uncertainty [rad/s].
    age : float
        Time since the gap was that [s].
    """

    gap: float
    uncertainty: float
    growth: float
    growth_uncertainty: float
    age: float

    @property
    def grown_uncertainty(self) -> float:
        """Standard uncertainty by now [rad]: nobody knows whether the screw has worn on."""
        grown = (self.growth * self.age, self.growth_uncertainty * self.age)
        return math.hypot(self.uncertainty, *grown)

    def aged(self, time: float) -> "RememberedGap":
        """Return the estimate some time [s] later."""
        return replace(self, age=self.age + max(time, 0.0))


@dataclass(frozen=True)
class TwinState:
    """State of a twin as its state file has it.

    Attributes
    ----------
    controller : str
        Name of the controller's node with its namespace.
    mechanism : mapping of str to (float or str)
        The estimator's kind, and the constants of the mechanism as the twin knows them.
    tolerance : float
        Dead-zone tolerance in force [m].
    voltage_offset : float or None
        Voltage offset in force [V]; None if it was left alone.
    gains : tuple of (str, float)
        Gains in force by the names of the controller's parameters; empty if left alone.
    lives : tuple of str
        Identifiers of the controllers in which they are in force: a controller that is started
        anew has another one.
    gap : RememberedGap or None
        The newest estimate.
    machine : MachineRecollection or None
        What the estimator knows of the machine.
    machine_age : float
        Time [s] since it was known.

    Raises
    ------
    ValueError
        For a number that cannot be, with field, value and what is allowed.
    """

    controller: str
    mechanism: Mapping[str, float | str]
    tolerance: float
    voltage_offset: float | None = None
    gains: tuple[tuple[str, float], ...] = ()
    lives: tuple[str, ...] = ()
    gap: RememberedGap | None = None
    machine: MachineRecollection | None = None
    machine_age: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.tolerance <= LARGEST_TOLERANCE:
            raise ValueError(
                f"TwinState.tolerance = {self.tolerance!r}: must be 0 to {LARGEST_TOLERANCE:g} m"
            )
        numbers = {**dict(self.gains), "machine_age": self.machine_age}
        if self.voltage_offset is not None:
            numbers["voltage_offset"] = self.voltage_offset
        if self.gap is not None:
            numbers |= {"gap": self.gap.gap, "growth": self.gap.growth, "gap.age": self.gap.age}
        for name, value in numbers.items():
            if not math.isfinite(value):
                raise ValueError(f"TwinState.{name} = {value!r}: must be finite")


def mechanism_of(kind: str, model: PlantModel) -> dict[str, float | str]:
    """Return what tells one mechanism, and the way to look at it, from another one.

    Parameters
    ----------
    kind : str
        The estimator's kind.
    model : PlantModel
        Constants of the mechanism, as the twin knows them.
    """
    parts = {"motor": model.motor, "lead_screw": model.lead_screw, "structure": model.structure}
    constants = {
        f"{prefix}.{name}": value
        for prefix, part in parts.items()
        for name, value in vars(part).items()
    }
    return {"estimator.kind": kind, **constants}


def remembered_gap(estimate: Estimate | None, now: float) -> RememberedGap | None:
    """Return what is kept of an estimate.

    Parameters
    ----------
    estimate : Estimate or None
        What is known; None for nothing.
    now : float
        Stamp of the newest telemetry [s].
    """
    if estimate is None or not estimate.is_known:
        return None
    return RememberedGap(
        estimate.gap,
        estimate.uncertainty,
        estimate.growth,
        estimate.growth_uncertainty,
        max(now - estimate.time, 0.0),
    )


def document_of(state: TwinState) -> Document:
    """Return a state as plain lists, texts and numbers; what is not finite is a text."""
    gap, machine = state.gap, state.machine
    return {
        "controller": state.controller,
        "mechanism": dict(state.mechanism),
        "in_force": {
            "dead_zone_tolerance": state.tolerance,
            "voltage_offset": state.voltage_offset,
            "gains": dict(state.gains),
            "lives": list(state.lives),
        },
        "gap": None if gap is None else {name: _plain(value) for name, value in vars(gap).items()},
        "machine": None
        if machine is None
        else {
            "constants": [*FACTORS, *EFFECTS],
            "expected": [float(value) for value in machine.machine.expected],
            "covariance": [[float(value) for value in row] for row in machine.machine.covariance],
            "present": sorted(machine.present),
            "cogs": machine.cogs,
            "has_offset": machine.has_offset,
            "age": state.machine_age,
        },
    }


def state_from(document: Document) -> TwinState:
    """Return the state of a document.

    Raises
    ------
    KeyError, TypeError, ValueError
        If it is none.
    """
    in_force, gap, machine = document["in_force"], document["gap"], document["machine"]
    offset = in_force["voltage_offset"]
    return TwinState(
        controller=str(document["controller"]),
        mechanism=dict(document["mechanism"]),
        tolerance=float(in_force["dead_zone_tolerance"]),
        voltage_offset=None if offset is None else float(offset),
        gains=tuple((str(name), float(value)) for name, value in in_force["gains"].items()),
        lives=tuple(map(str, in_force["lives"])),
        gap=None if gap is None else RememberedGap(**{k: float(v) for k, v in gap.items()}),
        machine=None if machine is None else _recollection(machine),
        machine_age=0.0 if machine is None else float(machine["age"]),
    )


def _recollection(document: Document) -> MachineRecollection:
    if document["constants"] != [*FACTORS, *EFFECTS]:
        raise ValueError("machine.constants: are not those of this version")
    expected = np.array(document["expected"], dtype=np.float64)
    covariance = np.array(document["covariance"], dtype=np.float64)
    if expected.shape != (CONSTANTS,) or covariance.shape != (CONSTANTS, CONSTANTS):
        raise ValueError(f"machine: must be {CONSTANTS} constants and their covariance")
    if not (np.isfinite(expected).all() and np.isfinite(covariance).all()):
        raise ValueError("machine: must be finite")
    if not (np.diag(covariance) > 0.0).all():
        raise ValueError("machine.covariance: must have a positive diagonal")
    present = frozenset(map(str, document["present"]))
    if not present <= set(EFFECTS):
        raise ValueError(f"machine.present = {sorted(present)!r}: must be of {', '.join(EFFECTS)}")
    knowledge = MachineKnowledge(expected, covariance)
    return MachineRecollection(
        knowledge, present, int(document["cogs"]), bool(document["has_offset"])
    )


def _plain(value: float) -> float | str:
    return value if math.isfinite(value) else str(value)
