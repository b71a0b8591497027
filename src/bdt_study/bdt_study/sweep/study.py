"""A study: which loops are run, and what is computed of each."""

import json
import math
from dataclasses import asdict, dataclass, field
from functools import cached_property, partial
from importlib.metadata import version
from typing import Any

from bdt_msgs_py.topics import TWIN_NODE
from bdt_study.sweep.axis import Axis

METHODS = ("random", "latin_hypercube", "sobol", "saltelli")
"""How distributions are sampled; saltelli is Sobol's sequence in the order that indices need."""

MOST_RUNS = 10**9
LONGEST = 1e6
"""Longest simulated time of a run [s]."""
MOST_SEEDS = 2**31
PACKAGE = "bdt_study"

NO_TWIN = "none"


@dataclass(frozen=True)
class Study:
    """Many loops.

    Attributes
    ----------
    name : str
        What it is called in the report.
    settings : tuple of (str, value)
        What is the same in all runs, by node and flat name: ``("plant.gap.kind", "constant")``.
    duration : float
        Simulated time of each run [s].
    estimator : str
        Estimator of the twin, ``none`` for loops without a twin.
    axes : tuple of Axis
        What differs from run to run.
    method : str
        How the axes that are no grid are sampled: one of ``METHODS``.
    samples : int
        Samples for each point of the grid; base samples for saltelli, which makes d + 2 of each.
    repetitions : int
        Runs of each point with other seeds of noise and link.
    seed : int
        Seed of everything that is drawn.
    compute : tuple of str
        What is computed of each run.
    version : str
        Version of this package: another one may compute something else.
    """

    name: str
    settings: tuple[tuple[str, Any], ...]
    duration: float
    estimator: str
    axes: tuple[Axis, ...]
    method: str = "sobol"
    samples: int = 1
    repetitions: int = 1
    seed: int = 0
    compute: tuple[str, ...] = ("limit_cycle", "bias_percent")
    version: str = field(default_factory=partial(version, PACKAGE))

    def __post_init__(self) -> None:
        if not 0.0 < self.duration <= LONGEST:
            raise ValueError(f"duration = {self.duration!r} s: must be above 0 to {LONGEST:g}")
        if self.method not in METHODS:
            raise ValueError(
                f"sample.method = {self.method!r}: must be one of {', '.join(METHODS)}"
            )
        for name, least in (("samples", 1), ("repetitions", 1), ("seed", 0)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise ValueError(f"{name} = {value!r}: must be an integer, at least {least}")
        if self.seed >= MOST_SEEDS:
            raise ValueError(f"seed = {self.seed!r}: must be below {MOST_SEEDS}")
        if self.samples > 1 and not self.drawn_axes:
            raise ValueError("sample: needs a parameter with a distribution")
        if (
            self.method in ("sobol", "saltelli")
            and self.drawn_axes
            and not _is_two_power(self.samples)
        ):
            raise ValueError(
                f"sample.count = {self.samples}: must be a power of two for {self.method}"
            )
        if not self.compute:
            raise ValueError("compute = []: must name at least one quantity")
        if self.runs > MOST_RUNS:
            raise ValueError(f"the study has {self.runs} runs: must be at most {MOST_RUNS}")

    @property
    def has_twin(self) -> bool:
        """Whether a twin is in the loop."""
        return self.estimator != NO_TWIN

    @property
    def grid_axes(self) -> tuple[Axis, ...]:
        """The axes of the grid, the last of which changes first."""
        return tuple(axis for axis in self.axes if axis.is_grid)

    @property
    def drawn_axes(self) -> tuple[Axis, ...]:
        """The axes that are sampled."""
        return tuple(axis for axis in self.axes if not axis.is_grid)

    @property
    def samples_at_each_point(self) -> int:
        """Samples for each point of the grid."""
        return self.samples * (len(self.drawn_axes) + 2 if self.method == "saltelli" else 1)

    @property
    def runs(self) -> int:
        """Number of runs."""
        points = math.prod(len(axis.values) for axis in self.grid_axes)
        return points * self.samples_at_each_point * self.repetitions

    @cached_property
    def text(self) -> str:
        """All of it as JSON, the same for the same study."""
        return json.dumps(asdict(self), sort_keys=True)

    def node_values(self) -> dict[str, dict[str, Any]]:
        """Return what is the same in all runs by node and flat name."""
        values: dict[str, dict[str, Any]] = {}
        for name, value in self.settings:
            node, _, flat = name.partition(".")
            values.setdefault(node, {})[flat] = value
        if self.has_twin:
            values.setdefault(TWIN_NODE, {})["estimator.kind"] = self.estimator
        return values


def study_from_text(text: str) -> Study:
    """Return the study whose text this is.

    Raises
    ------
    ValueError
        If it is the text of no study.
    """
    document = json.loads(text)
    try:
        axes = tuple(Axis(**_frozen(axis)) for axis in document.pop("axes"))
        return Study(axes=axes, **_frozen(document))
    except (AttributeError, KeyError, TypeError) as error:
        raise ValueError(f"is no study: {error}") from error


def _frozen(value: Any) -> Any:
    """Return what JSON holds with tuples in place of lists."""
    if isinstance(value, dict):
        return {name: _frozen(one) for name, one in value.items()}
    return tuple(map(_frozen, value)) if isinstance(value, list) else value


def _is_two_power(number: int) -> bool:
    return number & (number - 1) == 0
